// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/result.hpp"

namespace nacelle::calibration {

/// Two driven wheels as the parameters of the base describe them: those of diff_drive_controller.
struct BaseGeometry {
  double wheel_radius_m = 0.0;      ///< As the motor board has it, too; a calibration leaves it as it is.
  double wheel_separation_m = 0.0;  ///< Between the contact points; left as it is.
  double left_radius_multiplier = 1.0, right_radius_multiplier = 1.0, separation_multiplier = 1.0;

  [[nodiscard]] double left_radius_m() const { return wheel_radius_m * left_radius_multiplier; }
  [[nodiscard]] double right_radius_m() const { return wheel_radius_m * right_radius_multiplier; }
  [[nodiscard]] double separation_m() const { return wheel_separation_m * separation_multiplier; }
};

/// How far the wheels have turned, forward positive: the mean of each side's wheels.
struct WheelTurn {
  double left_rad = 0.0, right_rad = 0.0;
};
[[nodiscard]] WheelTurn operator-(const WheelTurn& to, const WheelTurn& from);

/// What the wheels say about the way of the base's middle. Source: diff_drive_controller, odometry.cpp: d = (dl + dr) / 2.
[[nodiscard]] double distance_m(const BaseGeometry& base, const WheelTurn& turn);
/// What the wheels say about the turn, counter-clockwise positive. Source: as above: (dr - dl) / L.
[[nodiscard]] double yaw_rad(const BaseGeometry& base, const WheelTurn& turn);

/// Why a measured motion is no calibration.
enum class BaseFault : std::uint8_t {
  NoMotion,     ///< The wheels have hardly turned, or the measured value is not positive.
  NotStraight,  ///< The wheels turned the base by more than 10 degrees while it should drive straight ahead.
  NotOnTheSpot,  ///< The base's middle moved by more than a quarter of the way of a wheel while it should turn on the spot.
  Absurd,        ///< Measured and odometry differ by more than a factor of two: another unit, or a wheel slipped.
};

/// Returns the base with both radius multipliers scaled so that the wheels' turns give the measured distance.
[[nodiscard]] Result<BaseGeometry, BaseFault> with_measured_distance(const BaseGeometry& base, const WheelTurn& turn,
                                                                     double measured_m);
/// Returns the base with the separation multiplier scaled so that the wheels' turns give the measured turn. The radii must be
/// right already.
[[nodiscard]] Result<BaseGeometry, BaseFault> with_measured_yaw(const BaseGeometry& base, const WheelTurn& turn,
                                                                double measured_rad);

}  // namespace nacelle::calibration
