// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {

/// A geared motor and its wheel: a speed that follows its supply with a time constant, and friction that takes the first part of it.
struct SimulatedMotor {
  double full_speed_rps = 20.0;  ///< At a supply of 1.
  double time_constant_s = 0.08;
  double dead_band = 0.0;  ///< A supply below this turns nothing.
  bool is_blocked = false;
  double speed_rps = 0.0;
  double angle_rad = 0.0;

  void run(double supply, double seconds) {
    constexpr double kStep = 0.0005;
    for (double left = seconds; left > 1e-9; left -= kStep) {
      const double step = std::min(left, kStep);
      const double beyond = std::max(0.0, std::abs(supply) - dead_band) / (1.0 - dead_band);
      const double aim_rps = std::copysign(beyond * full_speed_rps, supply);
      speed_rps += (aim_rps - speed_rps) * step / time_constant_s;
      if (is_blocked) speed_rps = 0.0;
      angle_rad += speed_rps * step;
    }
  }
};

}  // namespace nacelle::diff_drive
