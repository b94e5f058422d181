// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace nacelle::report {

/// Computes the rate of transforms, and their age at publication. Pure; one thread.
class FrameDelays {
 public:
  struct Row {
    double rate_hz = 0;                           ///< 0 for fewer than two samples.
    double average_delay_s = 0, max_delay_s = 0;  ///< Time from the stamp to publish().
    std::size_t count = 0;
  };

  /// Adds a sample; both times are of the wall clock.
  void note(const std::string& child, std::int64_t stamp_ns, std::int64_t published_ns);
  /// Returns the figures of the last thousand samples of a frame.
  [[nodiscard]] Row of(const std::string& child) const;
  /// Returns the figures of several frames together: mean and maximum of their delays, and the highest of their rates.
  [[nodiscard]] Row of_all(const std::vector<std::string>& children) const;

 private:
  struct Sample {
    std::int64_t published_ns = 0;
    double delay_s = 0;
  };
  std::map<std::string, std::deque<Sample>> samples_;
};

/// Returns the frames from one to another by way of their common ancestor, both included; empty if they are not
/// connected. `parents`: child -> parent.
[[nodiscard]] std::vector<std::string> chain_between(const std::map<std::string, std::string>& parents,
                                                     const std::string& from, const std::string& to);

}  // namespace nacelle::report
