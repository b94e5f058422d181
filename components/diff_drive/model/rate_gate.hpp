// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// Lets every n-th of a stream of events pass so that no more than one per period gets through on average.
///
/// The due time advances by whole periods and not to the present, so a source at the same rate passes whole in spite
/// of its jitter.
/// Source: diff_drive_controller's publish gating. Threads: belongs to one thread.
class RateGate {
 public:
  /// A period of zero lets everything pass.
  explicit RateGate(Duration period) : period_(period) {}

  [[nodiscard]] bool passes(MonotonicTime now) {
    if (now < due_) return false;
    due_ += period_;
    // A source slower than the rate must not save up a burst; two periods of slack are enough for its jitter.
    if (now - due_ > 2 * period_) due_ = now;
    return true;
  }

 private:
  Duration period_;
  MonotonicTime due_{};
};

}  // namespace nacelle::diff_drive
