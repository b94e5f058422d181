// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::runtime {

/// One stop frame as the watcher sees it, in memory that it shares with the container.
struct WatchedStop {
  std::atomic<int> descriptor{-1};
  std::size_t length = 0;
  std::size_t bytes_a_write = 0;  // CrashEntry::bytes_a_write
  std::array<std::uint8_t, 64> frame{};
};

/// A small process beside the container's that writes every registered stop frame when the container's process has
/// ended, in whatever way: SIGKILL, `_exit()`, a fault on a thread that blocks the fault signals or has no stack left.
/// It shares the table of open files with the container (CLONE_FILES), so a frame's descriptor needs no copy and a
/// `close()` of the driver takes effect at once. It blocks all signals but SIGKILL, leaves the process group, and ends
/// right after the container.
///
/// If the kernel refuses the process, a warning is logged and nothing else changes. One per process.
/// Source: docs/adr/0019-a-watcher-process-writes-the-last-stop.md. Threads: made and destroyed by one.
class StopWatcher final {
 public:
  /// Components with a stop frame beyond this number are not watched; the crash handler still writes theirs.
  static constexpr std::size_t kMost = 256;

  StopWatcher();
  /// Ends the watcher without a write.
  ~StopWatcher();
  StopWatcher(const StopWatcher&) = delete;
  StopWatcher& operator=(const StopWatcher&) = delete;

 private:
  pid_t process_ = -1;
};

/// Returns the watched copy of the stop frame with this number, or null if there is no watcher or the number is too
/// high.
[[nodiscard]] WatchedStop* watched_stop(std::size_t number) noexcept;

}  // namespace nacelle::runtime
