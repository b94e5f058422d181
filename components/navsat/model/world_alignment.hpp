// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/spatial/rigid_transform.hpp"
#include "navsat/model/geo_projection.hpp"

/// How the robot's world frame lies on the plane of a projection. Everything here is pure and allocates nothing.
///
/// Frames: W world (odom or map), C the plane of the projection, E true east and north, B base, A antenna.
/// Source: robot_localization, src/navsat_transform.cpp: computeTransform, getRobotOriginCartesianPose, getRobotOriginWorldPose.
namespace nacelle::navsat {

using spatial::RigidTransform;

/// What is added to a heading of a compass. Units: rad, counter-clockwise.
struct HeadingCorrection {
  /// Of magnetic north from true north. Positive to the west: counter-clockwise, as in robot_localization. Maps and NOAA count east.
  double declination_rad{};
  double yaw_offset_rad{};   ///< Of the sensor: pi/2 if it reads 0 towards north.
  double convergence_rad{};  ///< GeoProjection::convergence_rad().
  [[nodiscard]] double sum_rad() const { return declination_rad + yaw_offset_rad + convergence_rad; }
};

/// R_CB of a heading sensor's R_EB.
[[nodiscard]] Eigen::Quaterniond corrected(const Eigen::Quaterniond& R_EB, const HeadingCorrection& correction);

/// The base's origin, from the antenna's position and its place on the base.
[[nodiscard]] inline Eigen::Vector3d origin_of_base(const Eigen::Vector3d& p_antenna, const Eigen::Quaterniond& R_B,
                                                    const Eigen::Vector3d& p_BA) {
  return p_antenna - R_B * p_BA;
}

/// Where both frames meet: the robot's pose in each, at one time.
struct Alignment {
  RigidTransform X_WC, X_CW;
  double convergence_rad{};
};

/// Aligns the frames so that a robot at p_CB with the heading of R_CB is at X_WB. Roll and pitch do not count: both planes are level.
[[nodiscard]] Alignment align(const RigidTransform& X_WB, const Eigen::Vector3d& p_CB, const Eigen::Quaterniond& R_CB,
                              double convergence_rad);

/// The covariance of a fix (east, north, up) along the axes of the world, and back.
[[nodiscard]] Eigen::Matrix3d covariance_in_world(const Alignment& alignment, const Eigen::Matrix3d& covariance_E);
[[nodiscard]] Eigen::Matrix3d covariance_of_fix(const Alignment& alignment, const Eigen::Matrix3d& covariance_W);

}  // namespace nacelle::navsat
