// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

#include "nacelle/base/time.hpp"

namespace nacelle::io {

/// Tells when a device that sends at a steady pace measured, from when its bytes came.
///
/// A receive time is never too early but often too late, because the reading thread had to wait for a processor. Therefore the
/// earliest times count: a sample is placed one device step after the one before, earlier if it arrived earlier, and later only
/// by as much as two quartz clocks can differ. A lasting delay is accepted after a while.
///
/// A very late sample follows a gap, or is the first of a burst that waited for a delayed thread. The next sample decides: in a
/// burst it arrives at once, and all samples keep their places; after a gap it arrives one step later, and the gap is accepted.
/// The first sample after a gap is therefore placed as if there were no gap.
/// Threads: one. Allocates: nothing.
class ArrivalFilter {
 public:
  /// `creep`: how slowly it believes that the device is slower than it says: by 1/creep of a step. Default: kCreep.
  explicit ArrivalFilter(std::int64_t creep = kCreep) : creep_(creep) {}

  /// `read`: when the sample was read. `on_line`: how long before that it left the device at the least. `step`: the
  /// device's own time since the sample before.
  MonotonicTime settle(MonotonicTime read, Duration on_line, Duration step) {
    const MonotonicTime received = read - on_line;
    const MonotonicTime expected = last_ + step;
    const Duration late = received - expected;
    if (!started_ || step <= Duration::zero() || late > kLongestAway) {
      last_ = received;
      very_late_ = 0;
    } else if (late <= kGap) {
      // After a loss was believed too late time still goes forward: at half the pace.
      last_ = std::max(expected + std::min(late, std::max(step / creep_, Duration{1})), last_ + step / 2);
      very_late_ = 0;
    } else {
      if (very_late_ == 0) first_very_late_ = read;
      const bool in_a_burst = very_late_ == 0 || read - first_very_late_ < very_late_ * step * 3 / 4;
      last_ = in_a_burst ? expected : received;
      very_late_ = in_a_burst ? very_late_ + 1 : 0;
    }
    started_ = true;
    return last_;
  }
  /// Forgets the pace: the line was opened again.
  void restart() {
    started_ = false;
    very_late_ = 0;
  }

  /// A step may take a hundredth longer than the device says: crystals differ by 1/10000, motors' speed figures by
  /// more.
  static constexpr std::int64_t kCreep = 100;
  /// For steps of a quartz: five times what two of them differ by.
  static constexpr std::int64_t kQuartzCreep = 2000;
  /// Later than this is very late.
  static constexpr Duration kGap = 100ms;
  /// What came in a longer time does not wait in the line's buffer (4096 bytes): a gap.
  static constexpr Duration kLongestAway = 1s;

 private:
  const std::int64_t creep_;
  MonotonicTime last_{}, first_very_late_{};
  std::int64_t very_late_ = 0;  ///< Samples in a row that may belong to a burst.
  bool started_ = false;
};

}  // namespace nacelle::io
