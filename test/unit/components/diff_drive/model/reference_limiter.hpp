// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "diff_drive/model/axis_limits.hpp"

namespace nacelle::diff_drive {

/// The rate limiter's rules once more, written from the table of its behaviour and not from our code: the tests' judge.
///
/// "order jerk, then acceleration, then velocity clamp; v0 = previous, v1 = one before", defaults resolved here too.
class ReferenceLimiter {
 public:
  explicit ReferenceLimiter(const AxisLimits& given) : limits_(given) {
    auto fill = [](double& value, double from) { value = std::isnan(value) ? from : value; };
    fill(limits_.min_velocity, -limits_.max_velocity);
    fill(limits_.max_acceleration_reverse, -limits_.max_acceleration);
    fill(limits_.max_deceleration, limits_.max_acceleration_reverse);
    fill(limits_.max_deceleration_reverse, -limits_.max_deceleration);
    fill(limits_.min_jerk, -limits_.max_jerk);
  }

  [[nodiscard]] double limit(double v, double v0, double v1, double dt) const {
    if (has(limits_.max_jerk) && ((v - v0) - (v0 - v1)) * (v - v0) > 0) {
      const double wanted_change_of_change = (v - v0) - (v0 - v1);
      v = v0 + (v0 - v1) + between(limits_.min_jerk * dt * dt, wanted_change_of_change, limits_.max_jerk * dt * dt);
    }
    if (has(limits_.max_acceleration)) {
      double down = limits_.max_acceleration_reverse;
      double up = limits_.max_acceleration;
      if (v0 > 0) down = limits_.max_deceleration;
      if (v0 < 0) up = limits_.max_deceleration_reverse;
      v = v0 + between(down * dt, v - v0, up * dt);
    }
    if (has(limits_.max_velocity)) v = between(limits_.min_velocity, v, limits_.max_velocity);
    return v;
  }

 private:
  static bool has(double limit) { return !std::isnan(limit); }
  static double between(double low, double value, double high) { return std::max(low, std::min(high, value)); }
  AxisLimits limits_;
};

}  // namespace nacelle::diff_drive
