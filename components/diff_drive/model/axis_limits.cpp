// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/axis_limits.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {
namespace {

constexpr std::string_view kZeroOrPositive = "must be zero or positive, or .nan (off)";
constexpr std::string_view kZeroOrNegative = "must be zero or negative, or .nan (off)";

// The range of changes that the acceleration limits allow at the present speed.
SpeedChangeRange acceleration_range(const AxisLimits& limits, double speed, double dt_s) {
  if (std::isnan(limits.max_acceleration)) return {};
  if (speed > 0.0) return {limits.max_deceleration * dt_s, limits.max_acceleration * dt_s};
  if (speed < 0.0) return {limits.max_acceleration_reverse * dt_s, limits.max_deceleration_reverse * dt_s};
  return {limits.max_acceleration_reverse * dt_s, limits.max_acceleration * dt_s};
}

}  // namespace

Result<AxisLimits, LimitFault> resolved(AxisLimits limits) {
  struct Rule {
    std::string_view name;
    double value;
    bool positive;
  };
  const Rule rules[] = {
      {"max_velocity", limits.max_velocity, true},
      {"min_velocity", limits.min_velocity, false},
      {"max_acceleration", limits.max_acceleration, true},
      {"max_deceleration", limits.max_deceleration, false},
      {"max_acceleration_reverse", limits.max_acceleration_reverse, false},
      {"max_deceleration_reverse", limits.max_deceleration_reverse, true},
      {"max_jerk", limits.max_jerk, true},
      {"min_jerk", limits.min_jerk, false},
  };
  for (const Rule& rule : rules) {
    if (std::isnan(rule.value)) continue;
    if (std::isinf(rule.value)) return err(LimitFault{rule.name, rule.value, "must be finite; .nan switches it off"});
    if (rule.positive && rule.value < 0.0) return err(LimitFault{rule.name, rule.value, kZeroOrPositive});
    if (!rule.positive && rule.value > 0.0) return err(LimitFault{rule.name, rule.value, kZeroOrNegative});
  }

  if (std::isnan(limits.min_velocity)) limits.min_velocity = -limits.max_velocity;
  if (std::isnan(limits.max_acceleration_reverse)) limits.max_acceleration_reverse = -limits.max_acceleration;
  if (std::isnan(limits.max_deceleration)) limits.max_deceleration = limits.max_acceleration_reverse;
  if (std::isnan(limits.max_deceleration_reverse)) limits.max_deceleration_reverse = -limits.max_deceleration;
  if (std::isnan(limits.min_jerk)) limits.min_jerk = -limits.max_jerk;
  return limits;
}

double within_velocity(const AxisLimits& limits, double wanted) {
  return std::isnan(limits.max_velocity) ? wanted : std::clamp(wanted, limits.min_velocity, limits.max_velocity);
}

double limited_speed(const AxisLimits& limits, const AxisMemory& memory, double wanted, double dt_s) {
  double change = wanted - memory.last;
  if (!std::isnan(limits.max_jerk)) {
    const double last_change = memory.last - memory.before_last;
    // Only a growing change is limited: easing off is free, which keeps a closed loop from oscillating.
    if ((change - last_change) * change > 0.0) {
      change =
          last_change + std::clamp(change - last_change, limits.min_jerk * dt_s * dt_s, limits.max_jerk * dt_s * dt_s);
    }
  }
  const SpeedChangeRange range = acceleration_range(limits, memory.last, dt_s);
  const double clamped = std::clamp(change, range.lowest, range.highest);
  // An unlimited request is returned unchanged: last + (wanted - last) may differ from it by a rounding.
  const double speed = clamped == wanted - memory.last ? wanted : memory.last + clamped;
  return within_velocity(limits, speed);
}

SpeedChangeRange allowed_change(const AxisLimits& limits, const AxisMemory& memory, double dt_s) {
  SpeedChangeRange range = acceleration_range(limits, memory.last, dt_s);
  if (!std::isnan(limits.max_jerk)) {
    const double last_change = memory.last - memory.before_last;
    range.lowest = std::max(range.lowest, std::min(0.0, last_change + limits.min_jerk * dt_s * dt_s));
    range.highest = std::min(range.highest, std::max(0.0, last_change + limits.max_jerk * dt_s * dt_s));
  }
  if (!std::isnan(limits.max_velocity)) {
    range.lowest = std::max(range.lowest, std::min(0.0, limits.min_velocity - memory.last));
    range.highest = std::min(range.highest, std::max(0.0, limits.max_velocity - memory.last));
  }
  return range;
}

}  // namespace nacelle::diff_drive
