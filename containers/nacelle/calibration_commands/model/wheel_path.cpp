// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/wheel_path.hpp"

#include <cmath>

#include "odometry/model/wheel_odometry.hpp"

namespace nacelle::calibration {

PathEnd end_of(const BaseGeometry& base, const WheelPath& path) {
  PathEnd end;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const WheelTurn turned = path[i] - path[i - 1];
    const odometry::WheelStep step{base.left_radius_m() * turned.left_rad, base.right_radius_m() * turned.right_rad};
    const auto moved = odometry::move(end.pose.x(), end.pose.y(), end.pose.z(), step, base.separation_m());
    const double length_m = 0.5 * (std::abs(step.left_m) + std::abs(step.right_m));
    const double turn_rad = std::abs(moved.yaw_rad - end.pose.z());
    // left = distance - separation / 2 turn, right = distance + separation / 2 turn
    const Eigen::Vector3d by_distance = moved.by_step.col(0) + moved.by_step.col(1);
    const Eigen::Vector3d by_turn = 0.5 * base.separation_m() * (moved.by_step.col(1) - moved.by_step.col(0));
    const std::array<Eigen::Matrix3d, 3> added{length_m * by_distance * by_distance.transpose(),
                                               length_m * by_turn * by_turn.transpose(),
                                               turn_rad * by_turn * by_turn.transpose()};
    for (std::size_t part = 0; part < added.size(); ++part) {
      const Eigen::Matrix3d carried = moved.by_pose * end.by_slip[part] * moved.by_pose.transpose();
      end.by_slip[part] = carried + added[part];
    }
    end.pose = {moved.x_m, moved.y_m, moved.yaw_rad};
  }
  return end;
}

}  // namespace nacelle::calibration
