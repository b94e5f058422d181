// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/time.hpp"
#include "process/allocation_counter.hpp"

namespace nacelle::process {

/// The fields of /proc/<pid>/stat that we use.
struct StatLine {
  std::uint64_t user_ticks = 0, system_ticks = 0;
  std::uint64_t start_ticks = 0;  ///< Since boot.
  std::uint64_t threads = 0;
};
/// Source: proc_pid_stat(5). Errors: nothing for text of another form (the name in parentheses may hold anything).
[[nodiscard]] std::optional<StatLine> parse_stat_line(std::string_view text);

/// How long this process has been running, since exec (10 ms steps, the kernel's clock tick).
[[nodiscard]] Duration time_since_process_start();
/// Memory of this process that is in RAM. Allocates: nothing.
[[nodiscard]] std::uint64_t resident_bytes();
/// CPU time of this process, all threads, user and system. Allocates: nothing.
[[nodiscard]] Duration cpu_time();

struct NamedThread {
  int tid = 0;
  std::string name;
};
/// CPU time and memory of a process, or CPU time of a thread of this process (10 ms steps). Errors: nothing when it has ended.
struct Usage {
  Duration cpu{};
  std::uint64_t rss_bytes = 0;  ///< Of a process.
};
[[nodiscard]] std::optional<Usage> usage_of_process(int pid);
[[nodiscard]] std::optional<Duration> cpu_of_thread(int tid);
/// The threads of this process that live now.
[[nodiscard]] std::vector<NamedThread> living_threads();

/// Allocations per second of each thread name between two snapshots. Threads of one name add up; one that did not allocate
/// is there with 0. Only threads that lived at the end of the window are known by name; those that ended in it count under
/// "(ended)". Pure.
[[nodiscard]] std::map<std::string, double> allocation_rates(const AllocationSnapshot& before,
                                                             const AllocationSnapshot& after,
                                                             const std::vector<NamedThread>& threads, double seconds);

/// What the report says of the container's process.
struct ProcessFigures {
  std::optional<double> cpu_percent;  ///< Of one core. None: it was measured for too short a time.
  double rss_mb = 0;
  std::size_t threads = 0;
  std::map<std::string, double> allocations_per_second;  ///< Empty: not counted.
};

/// CPU over less says nothing.
inline constexpr Duration kShortestMeasure = 500ms;

/// Measures the steady state: begin() two seconds after the last activation, end() when the shutdown begins.
/// Threads: one.
class SteadyState {
 public:
  void begin(MonotonicTime now);
  [[nodiscard]] bool has_begun() const { return begun_; }
  /// Call when components were loaded or unloaded: discards the measurement.
  void reset() { begun_ = false; }
  /// Less than kShortestMeasure after begin(), or without it (a short run), the result has neither CPU nor allocations:
  /// they would be those of the bring-up, or of the kernel's ticks.
  [[nodiscard]] ProcessFigures end(MonotonicTime now);

 private:
  bool begun_ = false;
  MonotonicTime began_at_;
  Duration cpu_before_{};
  AllocationSnapshot before_{};
  AllocationSnapshot after_{};
};

}  // namespace nacelle::process
