// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

/// The rhythm of one timer on a clock that may stand, run at any pace and jump.
///
/// Source: rcl's timer.c: a jump ahead gives one tick and the next multiple of the period; a jump to before the last tick starts a full
/// period anew. Other than there, the first period begins with the first time that comes, not at 0.
class SimTicks {
 public:
  /// `listener` is told of each tick; it outlives this.
  SimTicks(Duration period, ReadyListener& listener) : period_(period), listener_(listener) {}

 private:
  friend class SimClock;
  void restart(Duration now);
  [[nodiscard]] bool is_due(Duration now);

  const Duration period_;
  ReadyListener& listener_;
  Duration last_{}, next_{};  // 0: no time has come yet
  std::uint64_t skipped_ = 0;
};

/// The clock of nodes with use_sim_time: ROS time is what /clock said last, and 0 before it says anything, as in rclcpp.
///
/// The monotonic line stays the kernel's: watchdogs and control timeouts must run even while the simulation stands.
/// Threads: any. Allocates: for a new timer only.
class SimClock final : public Clock, private ReadyListener {
 public:
  SimClock(const Clock& real, Transport& transport);

  [[nodiscard]] MonotonicTime now() const override { return real_.now(); }
  [[nodiscard]] WallTime wall_now() const override {
    return WallTime{Duration{time_ns_.load(std::memory_order_acquire)}};
  }

  /// Starts a period now; also for one that is there already.
  void add(SimTicks& ticks);
  /// Afterwards its listener is not told any more.
  void remove(SimTicks& ticks);
  [[nodiscard]] bool has(const SimTicks& ticks) const;
  /// Ticks that a jump ahead, or a pace faster than its period, left out.
  [[nodiscard]] std::uint64_t skipped(const SimTicks& ticks) const;

 private:
  void on_ready() noexcept override;

  const Clock& real_;
  std::atomic<std::int64_t> time_ns_{0};
  mutable FutexMutex mutex_;  // the timers, and one message after another
  std::vector<SimTicks*> timers_;
  std::atomic<Reader*> opened_{nullptr};  // a message may come before the constructor has the reader
  std::unique_ptr<Reader> reader_;        // last: it calls on_ready() until it is gone
};

}  // namespace nacelle::runtime
