// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "odometry/model/wheel_odometry.hpp"

namespace nacelle::odometry {

/// How much the motion over the ground differs from what the wheels rolled: standard deviations per root of the distance (m) and of
/// the angle (rad), so that variances add up along the way. `nacelle base calibrate` estimates them by driving.
///
/// The distance of a step is the mean of what both sides rolled, backwards or forwards, so a turn on the spot counts as well. The
/// defaults are those of a robot of ordinary make on a hard floor; outdoors, on carpet or on tracks five to twenty times as much is usual.
///
/// Source: the terms are those of Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), section 5.4 (a_trans and a_rot), with variances
///         that grow linearly as in Siegwart, Nourbakhsh, Scaramuzza (2011), eq. 5.8, so that they do not depend on the length of a step.
struct SlipModel {
  double distance_m = 0.005;  ///< m / sqrt(m): 5 mm after 1 m, 16 mm after 10 m.
  double lateral_m = 0.003;   ///< m / sqrt(m), sideways.
  double heading_rad = 0.02;  ///< rad / sqrt(m): 1.1 degrees after 1 m.
  double turn_rad = 0.015;    ///< rad / sqrt(rad): 2.2 degrees after a full turn.
};

/// Variances of one step: along, across (m^2), of its turn (rad^2), and the covariance of along and turn (m rad).
struct StepVariance {
  double along{}, across{}, turn{}, along_turn{};
};

[[nodiscard]] StepVariance variance_of(const WheelStep& step, double separation_m, const SlipModel& slip);
/// The same of the noise of each wheel.
[[nodiscard]] StepVariance variance_of(const WheelStep& step, double separation_m, const StepNoise& noise);

/// move() with the covariance: J_pose P J_pose^T + J_arc V J_arc^T, and `across` at right angles to the chord. Symmetric.
///
/// Units:     SI; separation_m > 0.
/// Threads:   pure. Allocates: nothing.
[[nodiscard]] PlanarPose integrate_with_slip(const PlanarPose& from, const WheelStep& step, double separation_m,
                                             const SlipModel& slip);

}  // namespace nacelle::odometry
