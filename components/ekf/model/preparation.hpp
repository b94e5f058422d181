// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/model/rotations.hpp"
#include "ekf/model/statistics.hpp"
#include "ekf/model/update.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/spatial/rigid_transform.hpp"

/// From what messages say in their frames to readings of the state. Everything here is pure and allocates nothing.
///
/// Frames: W world (odom or map), B base, S the sensor's or message's frame.
/// Source: robot_localization, src/ros_filter.cpp: preparePose, prepareTwist, prepareAcceleration, forceTwoD.
namespace nacelle::ekf {

using spatial::Matrix6d;
using spatial::RigidTransform;
using spatial::Vector6d;

/// What two_d_mode holds at zero.
inline constexpr StateMask kFlatStates =
    mask_of(kZ) | mask_of(kRoll) | mask_of(kPitch) | mask_of(kVz) | mask_of(kVroll) | mask_of(kVpitch) | mask_of(kAz);

/// What a filter wants of one part of a message.
struct PartSetup {
  StateMask mask{};  ///< Of the states that the part measures.
  double gate{std::numeric_limits<double>::infinity()};
  bool two_d{};                            ///< Add z, roll, pitch, vz, vroll, vpitch, az = 0 +- 0.001 to every reading.
  bool rotations_of_robot_localization{};  ///< Turns of tilted mountings as differences of angles; see docs/ekf.md.
};

using Prepared = Result<void, Rejection>;

/// A pose of B in the message's frame M. Covariance: position, then rotation, along the axes of M.
[[nodiscard]] Prepared prepare_pose(const RigidTransform& X_MB, const Matrix6d& covariance, const RigidTransform& X_WM,
                                    const PartSetup& setup, Reading& out);

/// A velocity of S, along the axes of S. The base turns with w_B, which moves a sensor that is not at its origin.
[[nodiscard]] Prepared prepare_twist(const Vector6d& twist_S, const Matrix6d& covariance, const RigidTransform& X_BS,
                                     const Eigen::Vector3d& w_B, const PartSetup& setup, Reading& out);

/// The base's orientation of an IMU's in an ENU world, and the reading of it. `covariance` is that of the IMU's roll, pitch and yaw; it and
/// the mask are turned by the mounting yaw.
[[nodiscard]] Eigen::Quaterniond base_orientation(const Eigen::Quaterniond& q_WS, const RigidTransform& X_BS,
                                                  const PartSetup& setup);
[[nodiscard]] Prepared prepare_orientation(const Eigen::Quaterniond& q_WB, const Eigen::Matrix3d& covariance,
                                           const RigidTransform& X_BS, const PartSetup& setup, Reading& out);

/// How the base turns while an accelerometer beside its origin measures.
struct Turning {
  Eigen::Vector3d w_B = Eigen::Vector3d::Zero();      ///< rad/s
  Eigen::Vector3d alpha_B = Eigen::Vector3d::Zero();  ///< rad/s^2
};
/// Acceleration of S along its axes; `gravity_S` is its reading at rest, which is subtracted (zero: keep it); robot_localization subtracts
/// it along the axes of B.
[[nodiscard]] Prepared prepare_acceleration(const Eigen::Vector3d& a_S, const Eigen::Matrix3d& covariance,
                                            const Eigen::Vector3d& gravity_S, const RigidTransform& X_BS,
                                            const Turning& turning, const PartSetup& setup, Reading& out);

/// The last pose of a differential input, or the first of a relative one.
struct PoseMemory {
  bool filled{};
  WallTime stamp{};
  RigidTransform X;
  Matrix6d covariance = Matrix6d::Zero();
};

/// The twist between the remembered pose and this one, as a reading of velocities; `setup.mask` names pose states.
/// The memory moves on in any case. Errors: Rejection::First for the first message, Stale when no time has passed.
[[nodiscard]] Prepared prepare_difference(PoseMemory& memory, WallTime stamp, const RigidTransform& X_now,
                                          const Matrix6d& covariance, const RigidTransform& X_BS,
                                          const Eigen::Vector3d& w_B, const PartSetup& setup, Reading& out);
/// The same of the base's orientation by an IMU; `covariance` as in prepare_orientation().
[[nodiscard]] Prepared prepare_turn(PoseMemory& memory, WallTime stamp, const Eigen::Quaterniond& q_WB,
                                    const Eigen::Matrix3d& covariance, const RigidTransform& X_BS,
                                    const PartSetup& setup, Reading& out);

/// The pose seen from the first one of the input.
[[nodiscard]] RigidTransform relative_to_first(PoseMemory& memory, const RigidTransform& X_now);

/// A unit quaternion from a message: all zeros become the identity, a length off by more than 0.01 is normalised.
/// Errors: Rejection::NotFinite.
[[nodiscard]] Result<Eigen::Quaterniond, Rejection> rotation_from(double x, double y, double z, double w);

}  // namespace nacelle::ekf
