// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/slip_model.hpp"

#include <cmath>

namespace nacelle::odometry {

StepVariance variance_of(const WheelStep& step, double separation_m, const SlipModel& slip) {
  const double path_m = 0.5 * (std::abs(step.left_m) + std::abs(step.right_m));
  const double turn_rad = std::abs(step.right_m - step.left_m) / separation_m;
  return {slip.distance_m * slip.distance_m * path_m, slip.lateral_m * slip.lateral_m * path_m,
          slip.heading_rad * slip.heading_rad * path_m + slip.turn_rad * slip.turn_rad * turn_rad, 0.0};
}

StepVariance variance_of(const WheelStep& step, double separation_m, const StepNoise& noise) {
  const double left = noise.k_left_m * std::abs(step.left_m);
  const double right = noise.k_right_m * std::abs(step.right_m);
  const double turn = noise.k_turn_rad * std::abs(step.right_m - step.left_m) / separation_m;
  return {0.25 * (left + right), 0.0, (left + right) / (separation_m * separation_m) + turn,
          0.5 * (right - left) / separation_m};
}

PlanarPose integrate_with_slip(const PlanarPose& from, const WheelStep& step, double separation_m,
                               const SlipModel& slip) {
  const Moved moved = move(from.x_m, from.y_m, from.yaw_rad, step, separation_m);
  const StepVariance v = variance_of(step, separation_m, slip);
  // Left and right of (distance, turn).
  Eigen::Matrix2d step_by_arc;
  step_by_arc << 1.0, -0.5 * separation_m, 1.0, 0.5 * separation_m;
  const Eigen::Matrix<double, 3, 2> by_arc = moved.by_step * step_by_arc;
  Eigen::Matrix2d arc_variance;
  arc_variance << v.along, v.along_turn, v.along_turn, v.turn;
  const double middle_rad = 0.5 * (from.yaw_rad + moved.yaw_rad);
  const Eigen::Vector3d across{-std::sin(middle_rad), std::cos(middle_rad), 0.0};

  PlanarPose to{moved.x_m, moved.y_m, moved.yaw_rad, {}};
  const Eigen::Matrix3d carried = moved.by_pose * from.covariance * moved.by_pose.transpose();
  const Eigen::Matrix3d added = by_arc * arc_variance * by_arc.transpose();
  const Eigen::Matrix3d sideways = v.across * across * across.transpose();
  to.covariance = carried + added + sideways;
  const Eigen::Matrix3d transposed = to.covariance.transpose();
  to.covariance = 0.5 * (to.covariance + transposed);
  return to;
}

}  // namespace nacelle::odometry
