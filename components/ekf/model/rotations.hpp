// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/spatial/rigid_transform.hpp"

/// Turns of sensors that are mounted askew, as rotations; and as robot_localization has them, as differences of angles.
/// Frames: W world, B base, S the sensor.
namespace nacelle::ekf {

/// The axis of a unit quaternion times its angle, at most pi long.
/// Threads: pure. Allocates: nothing.
[[nodiscard]] Eigen::Vector3d turn_vector(const Eigen::Quaterniond& rotation);

/// The constant twist (linear, angular) along the axes of the moving body that makes `step` in one unit of time.
///
/// A body that drives along an arc has no sideways velocity, although its chord is not along its first heading.
/// Threads: pure. Allocates: nothing.
/// Source:  Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics" (2018), eq. 174 and 146: the logarithm of SE(3).
[[nodiscard]] spatial::Vector6d twist_of(const spatial::RigidTransform& step);

/// The base's orientation of an IMU's: q_WS q_BS^-1.
[[nodiscard]] inline Eigen::Quaterniond base_orientation(const Eigen::Quaterniond& q_WS,
                                                         const Eigen::Quaterniond& q_BS) {
  return q_WS * q_BS.conjugate();
}

/// The same as robot_localization has it: the mounting angles are subtracted from the IMU's, and the differences are turned by the mounting
/// yaw. Equal to base_orientation() for a mounting that has yaw alone, to first order in roll and pitch.
/// Source: robot_localization, RosFilter::preparePose, steps 6a to 6c.
[[nodiscard]] Eigen::Quaterniond base_orientation_by_angles(const Eigen::Quaterniond& q_WS,
                                                            const Eigen::Quaterniond& q_BS);

}  // namespace nacelle::ekf
