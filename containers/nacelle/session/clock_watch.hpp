// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::session {

/// Reports that the wall clock may have been set. Threads: one.
class ClockAlarm {
 public:
  virtual ~ClockAlarm() = default;
  /// Returns a descriptor that becomes readable then, and occasionally without a reason; -1: never.
  [[nodiscard]] virtual int descriptor() const = 0;
  /// Resets the descriptor for the next event.
  virtual void take() = 0;
};

/// Returns the kernel's alarm: a timer of CLOCK_REALTIME that is cancelled when the clock is set
/// (TFD_TIMER_CANCEL_ON_SET).
[[nodiscard]] std::unique_ptr<ClockAlarm> make_kernel_clock_alarm();

/// Detects that the wall clock was set, by its offset to the monotonic clock. Slewing by NTP is not a step.
/// Threads: one. Allocates: nothing after construction.
class ClockWatch {
 public:
  ClockWatch(const Clock& clock, ClockAlarm& alarm) : clock_(clock), alarm_(alarm), offset_(offset()) {}

  [[nodiscard]] int descriptor() const { return alarm_.descriptor(); }
  /// Returns the step since the last call, or nothing if it is less than kLeastStep. Call it when the descriptor is
  /// readable.
  [[nodiscard]] std::optional<Duration> look();

  /// A smaller change is slewing over the alarm's longest period, or the noise of reading two clocks.
  static constexpr Duration kLeastStep = 50ms;

 private:
  [[nodiscard]] Duration offset() const { return clock_.wall_now().since_origin - clock_.now().since_origin; }

  const Clock& clock_;
  ClockAlarm& alarm_;
  Duration offset_;
};

/// A clock for tests, whose wall time is set from outside the process: a FIFO accepts lines with the step in seconds
/// ("-5", "3600").
///
/// CLOCK_REALTIME cannot be set for one process only (time namespaces do not include it), and a test must not set the
/// machine's.
/// Threads: Clock's members from any; take() from one.
class TestClock final : public Clock, public ClockAlarm {
 public:
  /// Errors: the FIFO cannot be opened.
  [[nodiscard]] static Result<std::unique_ptr<TestClock>, Problem> open(const std::string& fifo);
  ~TestClock() override;

  [[nodiscard]] MonotonicTime now() const override { return clock_.now(); }
  [[nodiscard]] WallTime wall_now() const override {
    return clock_.wall_now() + Duration{offset_ns_.load(std::memory_order_relaxed)};
  }
  [[nodiscard]] int descriptor() const override { return fifo_; }
  void take() override;

 private:
  explicit TestClock(int fifo) : fifo_(fifo) {}

  SystemClock clock_;
  std::atomic<std::int64_t> offset_ns_{0};
  const int fifo_;
  std::string line_;
};

}  // namespace nacelle::session
