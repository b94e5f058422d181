// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string_view>

#include "nacelle/base/result.hpp"

namespace nacelle::diff_drive {

/// Limits of one axis of motion, named and signed as diff_drive_controller's parameters. NaN: not limited.
///
/// Units: m/s, m/s^2, m/s^3 (or rad). "Reverse" is for a negative speed: there accelerating is negative.
struct AxisLimits {
  static constexpr double kOff = std::numeric_limits<double>::quiet_NaN();

  double max_velocity = kOff;              ///< >= 0; NaN switches the velocity limit off.
  double min_velocity = kOff;              ///< <= 0; NaN: -max_velocity.
  double max_acceleration = kOff;          ///< >= 0, speeding up forward; NaN switches all acceleration limits off.
  double max_deceleration = kOff;          ///< <= 0, braking while moving forward; NaN: max_acceleration_reverse.
  double max_acceleration_reverse = kOff;  ///< <= 0, speeding up backwards; NaN: -max_acceleration.
  double max_deceleration_reverse = kOff;  ///< >= 0, braking while moving backwards; NaN: -max_deceleration.
  double max_jerk = kOff;                  ///< >= 0; NaN switches the jerk limit off.
  double min_jerk = kOff;                  ///< <= 0; NaN: -max_jerk.
};

/// Why limits cannot be used: which one, its value, what it should be.
struct LimitFault {
  std::string_view name;  ///< Of the field: static text.
  double value = 0.0;
  std::string_view rule;  ///< "must be zero or positive, or NaN (off)": static text.
};

/// Checks signs and fills in what NaN stands for; the result is what the functions below take.
[[nodiscard]] Result<AxisLimits, LimitFault> resolved(AxisLimits limits);

/// The last two limited speeds of an axis.
struct AxisMemory {
  double last = 0.0;
  double before_last = 0.0;
};

/// Returns the limited speed for the request `wanted`, on this axis alone.
///
/// Source: control_toolbox RateLimiter::limit: jerk, then acceleration, then velocity.
/// Preconditions: resolved limits, finite speeds, dt_s > 0.
[[nodiscard]] double limited_speed(const AxisLimits& limits, const AxisMemory& memory, double wanted, double dt_s);

/// `wanted` clamped to the velocity limits only.
[[nodiscard]] double within_velocity(const AxisLimits& limits, double wanted);

/// Changes of speed that the limits let pass unchanged; always holds 0.
struct SpeedChangeRange {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};
[[nodiscard]] SpeedChangeRange allowed_change(const AxisLimits& limits, const AxisMemory& memory, double dt_s);

}  // namespace nacelle::diff_drive
