// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/host/transport.hpp"
#include "nacelle/runtime/futex.hpp"

namespace nacelle::runtime {

/// The schedule of one timer on a clock that may pause, run at any rate and jump.
///
/// Source: rcl's timer.c: after a jump forward there is one tick, and then the next multiple of the period; a jump to
/// before the last tick restarts a full period. Unlike there, the first period begins with the first time received, not
/// at 0.
class SimTicks {
 public:
  /// `listener` is called at each tick; it must outlive this.
  SimTicks(Duration period, ReadyListener& listener) : period_(period), listener_(listener) {}

 private:
  friend class SimClock;
  void restart(Duration now);
  [[nodiscard]] bool is_due(Duration now);

  const Duration period_;
  ReadyListener& listener_;
  Duration last_{}, next_{};  // 0: no time received yet
  std::uint64_t skipped_ = 0;
};

/// The clock of nodes with use_sim_time: ROS time is the last value of /clock, and 0 before the first one, as in
/// rclcpp.
///
/// Monotonic time stays the kernel's: watchdogs and control timeouts must run even while the simulation is paused.
/// Threads: any. Allocates: for a new timer only.
class SimClock final : public Clock, private ReadyListener {
 public:
  SimClock(const Clock& real, Transport& transport);

  [[nodiscard]] MonotonicTime now() const override { return real_.now(); }
  [[nodiscard]] WallTime wall_now() const override {
    return WallTime{Duration{time_ns_.load(std::memory_order_acquire)}};
  }

  /// Starts a period now, also for a timer that was added before.
  void add(SimTicks& ticks);
  /// Removes a timer. After this its listener is not called any more.
  void remove(SimTicks& ticks);
  [[nodiscard]] bool has(const SimTicks& ticks) const;
  /// Returns the number of ticks skipped by a jump forward, or by a rate faster than its period.
  [[nodiscard]] std::uint64_t skipped(const SimTicks& ticks) const;

 private:
  void on_ready() noexcept override;

  const Clock& real_;
  std::atomic<std::int64_t> time_ns_{0};
  mutable FutexMutex mutex_;  // guards the timers, and serialises messages
  std::vector<SimTicks*> timers_ NACELLE_GUARDED_BY(mutex_);
  std::atomic<Reader*> opened_{nullptr};  // reader_, for messages that arrive before it is set
  std::unique_ptr<Reader> reader_;        // the last member: it calls on_ready(), which uses the others
};

}  // namespace nacelle::runtime
