// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/base_fit.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::calibration {
namespace {

constexpr double kLeast_m = 0.05, kLeast_rad = 0.5;
constexpr double kMostCurve_rad = 10.0 * std::numbers::pi / 180.0;
constexpr double kMostFactor = 2.0;

/// measured / believed, if it can be a matter of calibration.
Result<double, BaseFault> factor_of(double measured, double believed, double least) {
  // Negated, so that a NaN does not pass.
  if (!(believed >= least && measured > 0.0)) return err(BaseFault::NoMotion);
  const double factor = measured / believed;
  if (!(factor <= kMostFactor && factor >= 1.0 / kMostFactor)) return err(BaseFault::Absurd);
  return factor;
}

}  // namespace

WheelTurn operator-(const WheelTurn& to, const WheelTurn& from) {
  return {to.left_rad - from.left_rad, to.right_rad - from.right_rad};
}

double distance_m(const BaseGeometry& base, const WheelTurn& turn) {
  return (base.left_radius_m() * turn.left_rad + base.right_radius_m() * turn.right_rad) / 2.0;
}

double yaw_rad(const BaseGeometry& base, const WheelTurn& turn) {
  return (base.right_radius_m() * turn.right_rad - base.left_radius_m() * turn.left_rad) / base.separation_m();
}

Result<BaseGeometry, BaseFault> with_measured_distance(const BaseGeometry& base, const WheelTurn& turn,
                                                       double measured_m) {
  const auto factor = factor_of(measured_m, distance_m(base, turn), kLeast_m);
  if (!factor) return err(factor.error());
  if (std::abs(yaw_rad(base, turn)) > kMostCurve_rad) return err(BaseFault::NotStraight);
  BaseGeometry mended = base;
  mended.left_radius_multiplier *= *factor;
  mended.right_radius_multiplier *= *factor;
  return mended;
}

Result<BaseGeometry, BaseFault> with_measured_yaw(const BaseGeometry& base, const WheelTurn& turn,
                                                  double measured_rad) {
  const double believed = yaw_rad(base, turn);
  const auto factor = factor_of(measured_rad, believed, kLeast_rad);
  if (!factor) return err(factor.error());
  const double way_of_a_wheel = believed * base.separation_m() / 2.0;
  if (std::abs(distance_m(base, turn)) > way_of_a_wheel / 4.0) return err(BaseFault::NotOnTheSpot);
  BaseGeometry mended = base;
  mended.separation_multiplier /= *factor;
  return mended;
}

}  // namespace nacelle::calibration
