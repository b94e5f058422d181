// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "calibration_commands/model/base_fit.hpp"

namespace nacelle::calibration {

/// How far the wheels had turned at each reading of a way. The first one is zero.
using WheelPath = std::vector<WheelTurn>;

/// How unsure a base's way is: variances that grow with it, independent of each other. The squares of the odometry's parameters
/// slip.distance_stddev_per_sqrt_m, slip.heading_stddev_per_sqrt_m and slip.heading_stddev_per_sqrt_rad. The distance of a step is the
/// mean of what both wheels rolled, forward or backward.
struct SlipNoise {
  double distance_m = 1e-5;       ///< Of the distance, per metre: m^2/m.
  double heading_per_m = 4e-4;    ///< Of the heading, per metre: rad^2/m.
  double heading_per_rad = 2e-4;  ///< Of the heading, per radian turned: rad^2/rad.
};

/// Where the wheels say that a way has ended. Frame: that of the base at the beginning. Order: x, y, yaw.
struct PathEnd {
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();  ///< The yaw counts turns.
  /// The covariance is the sum of these, each times its variance of SlipNoise, in that order.
  std::array<Eigen::Matrix3d, 3> by_slip{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
};

/// Integrates the readings of a way. Source: docs/notation.md section 4, and odometry/model/wheel_odometry.hpp.
[[nodiscard]] PathEnd end_of(const BaseGeometry& base, const WheelPath& path);

}  // namespace nacelle::calibration
