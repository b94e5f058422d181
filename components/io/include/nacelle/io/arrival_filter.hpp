// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// Tells when a device that sends at a steady pace measured, from when its bytes came.
///
/// A receive time is never too early but often too late: the reading thread had to wait for a processor. So the
/// earliest times are believed: a sample is placed one device step after the one before, sooner if it came sooner,
/// and later only by as much as two quartz clocks can differ. A lasting delay is believed after a while, a gap at once.
/// Threads: one. Allocates: nothing.
class ArrivalFilter {
 public:
  /// `received`: when this sample left the device at the latest. `step`: the device's own time since the sample before.
  MonotonicTime settle(MonotonicTime received, Duration step) {
    const MonotonicTime expected = last_ + step;
    const Duration late = received - expected;
    if (!started_ || late > kGap || step <= Duration::zero()) {
      last_ = received;
    } else {
      // After a loss was believed too late, or when a burst of old bytes comes, time still goes forward: at half the
      // pace.
      last_ = std::max(expected + std::min(late, std::max(step / kCreep, Duration{1})), last_ + step / 2);
    }
    started_ = true;
    return last_;
  }
  /// Forgets the pace: the line was opened again.
  void restart() { started_ = false; }

  /// A step may take a hundredth longer than the device says: crystals differ by 1/10000, motors' speed figures by
  /// more.
  static constexpr std::int64_t kCreep = 100;
  /// Later than this is not scheduling but a loss.
  static constexpr Duration kGap = 100ms;

 private:
  MonotonicTime last_{};
  bool started_ = false;
};

}  // namespace nacelle::io
