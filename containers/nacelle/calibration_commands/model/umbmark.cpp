// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/umbmark.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nacelle::calibration {
namespace {

SquareError centre_of(const std::vector<SquareError>& errors) {
  SquareError centre;
  for (const auto& error : errors) {
    centre.x_m += error.x_m / static_cast<double>(errors.size());
    centre.y_m += error.y_m / static_cast<double>(errors.size());
  }
  return centre;
}

}  // namespace

Umbmark umbmark_of(const std::vector<SquareError>& clockwise, const std::vector<SquareError>& counter_clockwise,
                   double side_m, double separation_m) {
  constexpr double kQuarter_rad = std::numbers::pi / 2.0;
  Umbmark found;
  const SquareError cw = found.clockwise = centre_of(clockwise);
  const SquareError ccw = found.counter_clockwise = centre_of(counter_clockwise);
  const double four = -4.0 * side_m;
  found.alpha_rad = 0.5 * ((cw.x_m + ccw.x_m) / four + (cw.y_m - ccw.y_m) / four);
  found.beta_rad = 0.5 * ((cw.x_m - ccw.x_m) / four + (cw.y_m + ccw.y_m) / four);
  found.separation_ratio = kQuarter_rad / (kQuarter_rad - found.alpha_rad);
  // (R + b/2) / (R - b/2) with R = (L/2) / sin(beta/2), written so that it holds for beta = 0.
  const double bend = separation_m * std::sin(0.5 * found.beta_rad) / side_m;
  found.radius_ratio = (1.0 + bend) / (1.0 - bend);
  found.worst_m = std::max(std::hypot(cw.x_m, cw.y_m), std::hypot(ccw.x_m, ccw.y_m));
  return found;
}

BaseGeometry corrected(const BaseGeometry& believed, const Umbmark& found) {
  BaseGeometry base = believed;
  base.separation_multiplier *= found.separation_ratio;
  base.left_radius_multiplier *= 2.0 / (found.radius_ratio + 1.0);
  base.right_radius_multiplier *= 2.0 / (1.0 / found.radius_ratio + 1.0);
  return base;
}

}  // namespace nacelle::calibration
