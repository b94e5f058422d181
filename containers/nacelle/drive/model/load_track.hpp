// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drive/model/thinned_log.hpp"
#include "run_page/figures.hpp"

namespace nacelle::drive {

/// Computes CPU load, memory and rates over a run from counters of the robot.
///
/// Threads: one. Memory: bounded for a bounded number of streams.
class LoadTrack {
 public:
  /// Messages published so far, by stream.
  using Counts = std::vector<std::pair<std::string, std::uint64_t>>;

  /// Adds a sample: the CPU time so far, the memory in RAM, and the counts. Times rise.
  void add(double time_s, double cpu_s, double rss_mb, const Counts& published);

  /// Returns the CPU load in % of a core, each value the mean over a second or a little more.
  [[nodiscard]] std::vector<run_page::Sample> cpu_percents() const;
  [[nodiscard]] std::vector<run_page::Sample> rss_mbs() const;
  /// Returns the rates of a stream since its first message, each the mean over two seconds, or over twenty messages if that is longer.
  /// Empty if the run was shorter than that.
  [[nodiscard]] std::vector<run_page::Sample> rates_hz(const std::string& stream) const;

 private:
  struct Point {
    double time_s = 0.0, cpu_s = 0.0, rss_mb = 0.0;
    std::vector<std::uint64_t> published;  // by number of the stream; streams that came later are missing
    [[nodiscard]] std::uint64_t count(std::size_t stream) const {
      return stream < published.size() ? published[stream] : 0;
    }
  };
  std::map<std::string, std::size_t> numbers_;
  ThinnedLog<Point> log_{2048};
};

/// Returns the lowest value; NaN if there is none. Pure.
[[nodiscard]] double lowest_of(const std::vector<run_page::Sample>& samples);

}  // namespace nacelle::drive
