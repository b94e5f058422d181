// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace nacelle::odometry {

/// Where the base is in odom (X_OB) and how sure that is. Covariance order: x, y, yaw; m^2, m rad, rad^2.
struct PlanarPose {
  double x_m{}, y_m{};
  double yaw_rad{};  ///< Not wrapped: it counts the turns.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// How far each side rolled since the last sample; backwards is negative.
struct WheelStep {
  double left_m{}, right_m{};
};

/// How unsure a step is. Wheels slip and are not quite round: the variance of a side's distance grows with that distance. Where
/// the wheels touch the ground is not one point: the variance of a turn grows with the turn.
///
/// Source: k_left and k_right as in Siegwart, Nourbakhsh, Scaramuzza, "Introduction to Autonomous Mobile Robots" (2nd ed.,
///         2011), eq. 5.8; the turn term is the a_rot/rot part of Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), sec. 5.4.
struct StepNoise {
  double k_left_m = 2e-5;    ///< m^2 per m. 2e-5: 4.5 mm after 1 m, 14 mm after 10 m.
  double k_right_m = 2e-5;   ///< m^2 per m.
  double k_turn_rad = 2e-4;  ///< rad^2 per rad. 2e-4: 2.0 degrees after a full turn.
};

/// The pose after a step and the slopes of (x, y, yaw) with respect to the pose before and to (left_m, right_m).
struct Moved {
  double x_m{}, y_m{}, yaw_rad{};
  Eigen::Matrix3d by_pose;
  Eigen::Matrix<double, 3, 2> by_step;
};

/// Moves along the arc that both wheels rolled on; below 1e-6 rad of turn along its chord (second order Runge-Kutta), where
/// the arc's radius is no longer a number and the difference is below 1e-13 of the distance.
///
/// Units:     SI; separation_m > 0.
/// Threads:   pure. Allocates: nothing.
/// Source:    docs/notation.md section 4; diff_drive_controller, src/odometry.cpp.
[[nodiscard]] Moved move(double x_m, double y_m, double yaw_rad, const WheelStep& step, double separation_m);

/// move() with the covariance: J_pose P J_pose^T + J_step diag(k |step|) J_step^T, plus k_turn |turn| on the yaw.
/// The result is symmetric, and no variance ever shrinks below what a step adds.
[[nodiscard]] PlanarPose integrate(const PlanarPose& from, const WheelStep& step, double separation_m,
                                   const StepNoise& noise);

}  // namespace nacelle::odometry
