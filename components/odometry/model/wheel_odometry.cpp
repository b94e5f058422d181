// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/wheel_odometry.hpp"

#include <cmath>

namespace nacelle::odometry {
namespace {

constexpr double kStraight_rad = 1e-6;  // diff_drive_controller's limit

// The arc seen from its start, x ahead: (along, across), and their slopes by distance and turn.
struct Arc {
  double along, across;
  double along_by_turn, across_by_turn;
  double along_by_distance, across_by_distance;
};

Arc arc_of(double distance_m, double turn_rad) {
  if (std::abs(turn_rad) < kStraight_rad) {
    // The chord, d (cos(turn/2), sin(turn/2)), with the first terms of the exact slopes.
    const double half = 0.5 * turn_rad;
    return {distance_m * std::cos(half),
            distance_m * std::sin(half),
            -distance_m * turn_rad / 3.0,
            0.5 * distance_m,
            std::cos(half),
            std::sin(half)};
  }
  const double s = std::sin(turn_rad), c = std::cos(turn_rad);
  const double sinc = s / turn_rad;  // along / distance
  // (1 - cos) / turn, without the cancellation of 1 - cos.
  const double half_sine = std::sin(0.5 * turn_rad);
  const double versinc = 2.0 * half_sine * half_sine / turn_rad;
  return {distance_m * sinc,
          distance_m * versinc,
          distance_m * (c - sinc) / turn_rad,
          distance_m * (s - versinc) / turn_rad,
          sinc,
          versinc};
}

}  // namespace

Moved move(double x_m, double y_m, double yaw_rad, const WheelStep& step, double separation_m) {
  const double distance_m = 0.5 * (step.left_m + step.right_m);
  const double turn_rad = (step.right_m - step.left_m) / separation_m;
  const Arc arc = arc_of(distance_m, turn_rad);
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const double dx = c * arc.along - s * arc.across;
  const double dy = s * arc.along + c * arc.across;

  Moved to;
  to.x_m = x_m + dx;
  to.y_m = y_m + dy;
  to.yaw_rad = yaw_rad + turn_rad;
  to.by_pose << 1, 0, -dy, 0, 1, dx, 0, 0, 1;
  Eigen::Matrix<double, 3, 2> by_arc;  // columns: distance, turn
  by_arc << c * arc.along_by_distance - s * arc.across_by_distance, c * arc.along_by_turn - s * arc.across_by_turn,
      s * arc.along_by_distance + c * arc.across_by_distance, s * arc.along_by_turn + c * arc.across_by_turn, 0.0, 1.0;
  Eigen::Matrix2d arc_by_step;  // rows: distance, turn; columns: left, right
  arc_by_step << 0.5, 0.5, -1.0 / separation_m, 1.0 / separation_m;
  to.by_step.noalias() = by_arc * arc_by_step;
  return to;
}

PlanarPose integrate(const PlanarPose& from, const WheelStep& step, double separation_m, const StepNoise& noise) {
  const Moved moved = move(from.x_m, from.y_m, from.yaw_rad, step, separation_m);
  const Eigen::Vector2d variance{noise.k_left_m * std::abs(step.left_m), noise.k_right_m * std::abs(step.right_m)};
  PlanarPose to{moved.x_m, moved.y_m, moved.yaw_rad, {}};
  const Eigen::Matrix3d carried = moved.by_pose * from.covariance * moved.by_pose.transpose();
  const Eigen::Matrix3d added = moved.by_step * variance.asDiagonal() * moved.by_step.transpose();
  to.covariance = carried + added;
  to.covariance(2, 2) += noise.k_turn_rad * std::abs(moved.yaw_rad - from.yaw_rad);
  const Eigen::Matrix3d transposed = to.covariance.transpose();
  to.covariance = 0.5 * (to.covariance + transposed);
  return to;
}

}  // namespace nacelle::odometry
