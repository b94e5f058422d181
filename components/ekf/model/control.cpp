// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/control.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::ekf {

double control_acceleration(double velocity, double command, const ControlOptions& options, std::size_t axis) {
  constexpr double kSameSign = 0.01;  // robot_localization's
  const double gap = command - velocity;
  // A command that asks for the other direction brakes to zero first.
  const double set_point = std::abs(gap) <= std::abs(command) + kSameSign ? command : 0.0;
  const bool brakes = std::abs(set_point) < std::abs(velocity);
  const double limit = (brakes ? options.deceleration_limits : options.acceleration_limits)[axis];
  const double gain = (brakes ? options.deceleration_gains : options.acceleration_gains)[axis];
  return std::min(std::max(gain * gap, -limit), limit);
}

void apply_control(StateVector& state, const std::array<double, ControlOptions::kAxes>& command, double dt_s,
                   const ControlOptions& options) {
  for (std::size_t axis = 0; axis < ControlOptions::kAxes; ++axis) {
    if (!options.controlled[axis]) continue;
    const auto at = static_cast<int>(axis);
    const double acceleration = control_acceleration(state[kVx + at], command[axis], options, axis);
    if (axis < 3) {
      state[kAx + at] = acceleration;
    } else {
      state[kVx + at] += acceleration * dt_s;
    }
  }
}

}  // namespace nacelle::ekf
