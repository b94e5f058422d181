// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

namespace nacelle::spatial {

inline constexpr double kPi = std::numbers::pi;

/// The same direction in (-pi, pi]; a non-finite angle stays non-finite.
[[nodiscard]] inline double wrap_to_pi(double angle_rad) {
  if (angle_rad > -kPi && angle_rad <= kPi) return angle_rad;  // nearly always
  const double wrapped = std::remainder(angle_rad, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

/// The turn from one direction to another, the short way round, in (-pi, pi].
[[nodiscard]] inline double shortest_turn(double from_rad, double to_rad) { return wrap_to_pi(to_rad - from_rad); }

}  // namespace nacelle::spatial
