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

/// Fields of /proc/<pid>/stat.
struct StatLine {
  std::uint64_t user_ticks = 0, system_ticks = 0;
  std::uint64_t start_ticks = 0;  ///< Since boot.
  std::uint64_t threads = 0;
};
/// Parses the text of /proc/<pid>/stat. Returns nothing for another form (the name in parentheses may contain
/// anything). Source: proc_pid_stat(5).
[[nodiscard]] std::optional<StatLine> parse_stat_line(std::string_view text);

/// Returns the time since exec of this process (10 ms steps, the kernel's clock tick).
[[nodiscard]] Duration time_since_process_start();
/// Returns the memory of this process that is in RAM. Allocates: nothing.
[[nodiscard]] std::uint64_t resident_bytes();
/// Returns the CPU time of this process: all threads, user and system. Allocates: nothing.
[[nodiscard]] Duration cpu_time();

struct NamedThread {
  int tid = 0;
  std::string name;
};
/// CPU time (10 ms steps) and memory of a process. The functions return nothing if the process or thread has ended.
struct Usage {
  Duration cpu{};
  std::uint64_t rss_bytes = 0;  ///< Memory in RAM.
};
[[nodiscard]] std::optional<Usage> usage_of_process(int pid);
[[nodiscard]] std::optional<Duration> cpu_of_thread(int tid);
/// Returns the present threads of this process.
[[nodiscard]] std::vector<NamedThread> living_threads();

/// Returns the allocations per second of each thread name between two snapshots. Threads of the same name are added up.
/// A thread that did not allocate is listed with 0. Only threads that exist at the end of the window are known by name;
/// those that ended in it count under "(ended)". Pure.
[[nodiscard]] std::map<std::string, double> allocation_rates(const AllocationSnapshot& before,
                                                             const AllocationSnapshot& after,
                                                             const std::vector<NamedThread>& threads, double seconds);

/// Figures of the container's process, for the report.
struct ProcessFigures {
  std::optional<double> cpu_percent;  ///< Of one core; none: the measurement was too short.
  double rss_mb = 0;
  std::size_t threads = 0;
  std::map<std::string, double> allocations_per_second;  ///< Empty: not counted.
};

/// A shorter measurement gives no CPU load and no allocation rates.
inline constexpr Duration kShortestMeasure = 500ms;

/// Measures the steady state. Call begin() two seconds after the last change of the composition, and end() when the
/// shutdown begins.
/// Threads: one.
class SteadyState {
 public:
  void begin(MonotonicTime now);
  [[nodiscard]] bool has_begun() const { return begun_; }
  /// Discards the measurement. Call it when components were loaded or unloaded.
  void reset() { begun_ = false; }
  /// Returns the figures. Less than kShortestMeasure after begin(), or without it (a short run), they have neither CPU
  /// nor allocations: those would belong to the bring-up, or be smaller than the kernel's clock tick.
  [[nodiscard]] ProcessFigures end(MonotonicTime now);

 private:
  bool begun_ = false;
  MonotonicTime began_at_;
  Duration cpu_before_{};
  AllocationSnapshot before_{};
  AllocationSnapshot after_{};
};

}  // namespace nacelle::process
