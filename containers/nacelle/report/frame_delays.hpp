// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace nacelle::report {

/// How regularly transforms come, and how old they are when they are published. Pure; one thread.
class FrameDelays {
 public:
  struct Row {
    double rate_hz = 0;                           ///< 0 for fewer than two.
    double average_delay_s = 0, max_delay_s = 0;  ///< From the stamp to publish().
    std::size_t count = 0;
  };

  /// Times of the wall clock.
  void note(const std::string& child, std::int64_t stamp_ns, std::int64_t published_ns);
  /// Of the last thousand of that frame.
  [[nodiscard]] Row of(const std::string& child) const;
  /// Of several frames together: the mean of their delays, the longest, and the rate of the one that comes most often.
  [[nodiscard]] Row of_all(const std::vector<std::string>& children) const;

 private:
  struct Sample {
    std::int64_t published_ns = 0;
    double delay_s = 0;
  };
  std::map<std::string, std::deque<Sample>> samples_;
};

/// The frames from one to another, both included, by way of their common ancestor; empty if no chain joins them.
/// `parents`: child -> parent.
[[nodiscard]] std::vector<std::string> chain_between(const std::map<std::string, std::string>& parents,
                                                     const std::string& from, const std::string& to);

}  // namespace nacelle::report
