// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/wheel_travel.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {

double WheelTravel::step(double now_rad, double before_rad) const {
  const double step_rad = now_rad - before_rad;
  return settings_.wrap_rad > 0.0 ? std::remainder(step_rad, settings_.wrap_rad) : step_rad;
}

void WheelTravel::advance(const WheelReading& reading, MonotonicTime captured_at) {
  if (has_reading_) captured_at = std::max(captured_at, captured_at_);
  const double elapsed_s = has_reading_ ? to_seconds(captured_at - captured_at_) : 0.0;
  captured_at_ = captured_at;
  const WheelReading before = last_;
  last_ = reading;
  if (!reading.has_position) {
    has_reading_ = true;
    left_rad_ += reading.rates.left_rps * elapsed_s;
    right_rad_ += reading.rates.right_rps * elapsed_s;
    return;
  }
  if (!has_reading_) {
    // The first report of all is where the count starts. After a pause the wheels may have been turned by hand.
    if (!has_start_) {
      left_rad_ = reading.left_rad;
      right_rad_ = reading.right_rad;
    }
    has_reading_ = has_start_ = true;
    return;
  }
  const double left_rad = step(reading.left_rad, before.left_rad);
  const double right_rad = step(reading.right_rad, before.right_rad);
  const double reach_rad = 2.0 * settings_.max_wheel_rate_rps * elapsed_s + settings_.slack_rad;
  if (std::abs(left_rad) > reach_rad || std::abs(right_rad) > reach_rad) {
    ++restarts_;
    return;
  }
  left_rad_ += left_rad;
  right_rad_ += right_rad;
}

}  // namespace nacelle::diff_drive
