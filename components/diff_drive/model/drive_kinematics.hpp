// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace nacelle::diff_drive {

/// How fast the base moves over the ground: all that a differential drive can do.
///
/// Frame: v_OB_B, the velocity of the base in odom, expressed in the base: x forward, yaw counter-clockwise from above.
struct BodyTwist {
  double linear_mps = 0.0;
  double angular_rps = 0.0;
  friend bool operator==(const BodyTwist&, const BodyTwist&) = default;
};

/// How fast the wheels turn; positive drives the base forward.
struct WheelRates {
  double left_rps = 0.0;
  double right_rps = 0.0;
  friend bool operator==(const WheelRates&, const WheelRates&) = default;
};

/// The drive as the kinematics see it: multipliers are already inside. All lengths are positive.
struct DriveGeometry {
  double wheel_separation_m = 0.30;
  double left_wheel_radius_m = 0.033;
  double right_wheel_radius_m = 0.033;
};

/// Wheel rates that move the base like this.
/// Source: diff_drive_controller: left = (v - w L/2) / r_left, right = (v + w L/2) / r_right.
[[nodiscard]] inline WheelRates wheel_rates(const DriveGeometry& drive, const BodyTwist& v_OB_B) {
  const double turn_mps = v_OB_B.angular_rps * drive.wheel_separation_m / 2.0;
  return {(v_OB_B.linear_mps - turn_mps) / drive.left_wheel_radius_m,
          (v_OB_B.linear_mps + turn_mps) / drive.right_wheel_radius_m};
}

/// How the base moves when the wheels turn like this and do not slip: the inverse of wheel_rates().
[[nodiscard]] inline BodyTwist body_twist(const DriveGeometry& drive, const WheelRates& wheels) {
  const double left_mps = wheels.left_rps * drive.left_wheel_radius_m;
  const double right_mps = wheels.right_rps * drive.right_wheel_radius_m;
  return {(left_mps + right_mps) / 2.0, (right_mps - left_mps) / drive.wheel_separation_m};
}

/// Scales both parts by one factor: the path stays, the speed changes.
[[nodiscard]] inline BodyTwist scaled(const BodyTwist& twist, double factor) {
  return {twist.linear_mps * factor, twist.angular_rps * factor};
}

/// The same path at the highest speed that no wheel exceeds. Precondition: max_wheel_rps > 0 (infinity: no limit).
[[nodiscard]] inline BodyTwist within_wheel_rate(const DriveGeometry& drive, const BodyTwist& twist,
                                                 double max_wheel_rps) {
  const WheelRates wheels = wheel_rates(drive, twist);
  const double fastest_rps = std::max(std::abs(wheels.left_rps), std::abs(wheels.right_rps));
  return fastest_rps > max_wheel_rps ? scaled(twist, max_wheel_rps / fastest_rps) : twist;
}

}  // namespace nacelle::diff_drive
