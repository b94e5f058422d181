// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/rotations.hpp"

#include <cmath>

namespace nacelle::ekf {

using spatial::RigidTransform;
using spatial::RollPitchYaw;
using spatial::Vector6d;
using spatial::wrap_to_pi;

Eigen::Vector3d turn_vector(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;  // q and -q are one rotation; take the shorter way
  const double sine = rotation.vec().norm();
  // atan2(s, c) / s is 1 / c to second order: below 1e-8 that is exact.
  const double half = sine < 1e-8 ? 1.0 : std::atan2(sine, sign * rotation.w()) / sine;
  return 2.0 * half * sign * rotation.vec();
}

Vector6d twist_of(const RigidTransform& step) {
  const Eigen::Vector3d turn = turn_vector(step.rotation);
  const double square = turn.squaredNorm();
  const double angle = std::sqrt(square);
  // (1 - (angle / 2) cot(angle / 2)) / angle^2; its series, for below 1e-2 the difference loses digits.
  const double bend = angle < 1e-2 ? 1.0 / 12.0 + square / 720.0 : (1.0 - 0.5 * angle / std::tan(0.5 * angle)) / square;
  const Eigen::Vector3d once = turn.cross(step.translation_m);
  Vector6d twist;
  twist << step.translation_m - 0.5 * once + bend * turn.cross(once), turn;
  return twist;
}

Eigen::Quaterniond base_orientation_by_angles(const Eigen::Quaterniond& q_WS, const Eigen::Quaterniond& q_BS) {
  const RollPitchYaw mount = spatial::rpy_from_quaternion(q_BS);
  const RollPitchYaw seen = spatial::rpy_from_quaternion(q_WS);
  // An IMU that faces sideways pitches when the robot rolls.
  const Eigen::Vector3d left =
      spatial::matrix_from_rpy({0.0, 0.0, mount.yaw_rad}) *
      Eigen::Vector3d{wrap_to_pi(seen.roll_rad - mount.roll_rad), wrap_to_pi(seen.pitch_rad - mount.pitch_rad),
                      wrap_to_pi(seen.yaw_rad - mount.yaw_rad)};
  return spatial::quaternion_from_rpy({left.x(), left.y(), left.z()});
}

}  // namespace nacelle::ekf
