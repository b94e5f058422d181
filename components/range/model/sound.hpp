// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>

#include "nacelle/base/time.hpp"

namespace nacelle::range {

/// Speed of sound in dry air. Source: c = 331.3 m/s * sqrt(T / 273.15 K), of an ideal gas.
[[nodiscard]] inline double speed_of_sound_mps(double temperature_c) {
  return 331.3 * std::sqrt(1.0 + temperature_c / 273.15);
}

/// The distance of what sent the sound back, as REP 117 asks: +Inf if it is farther than `most_m`, -Inf if nearer than `least_m`.
/// `echo`: from the sound's leaving to its return.
[[nodiscard]] inline double echo_range_m(Duration echo, double temperature_c, double least_m, double most_m) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double range_m = to_seconds(echo) * speed_of_sound_mps(temperature_c) / 2.0;
  return range_m > most_m ? kInfinity : range_m < least_m ? -kInfinity : range_m;
}

}  // namespace nacelle::range
