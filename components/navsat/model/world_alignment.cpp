// SPDX-License-Identifier: Apache-2.0
#include "navsat/model/world_alignment.hpp"

namespace nacelle::navsat {
namespace {

/// R_WE: the grid's axes are turned by the convergence, clockwise.
Eigen::Matrix3d world_from_east_north(const Alignment& alignment) {
  return (alignment.X_WC.rotation * spatial::quaternion_from_yaw(alignment.convergence_rad)).toRotationMatrix();
}

}  // namespace

Eigen::Quaterniond corrected(const Eigen::Quaterniond& R_EB, const HeadingCorrection& correction) {
  return spatial::quaternion_from_yaw(correction.sum_rad()) * R_EB;
}

Alignment align(const RigidTransform& X_WB, const Eigen::Vector3d& p_CB, const Eigen::Quaterniond& R_CB,
                double convergence_rad) {
  const RigidTransform level_WB{spatial::quaternion_from_yaw(spatial::yaw_from_quaternion(X_WB.rotation)),
                                X_WB.translation_m};
  const RigidTransform level_CB{spatial::quaternion_from_yaw(spatial::yaw_from_quaternion(R_CB)), p_CB};
  Alignment alignment;
  alignment.X_WC = level_WB * level_CB.inverse();
  alignment.X_CW = alignment.X_WC.inverse();
  alignment.convergence_rad = convergence_rad;
  return alignment;
}

Eigen::Matrix3d covariance_in_world(const Alignment& alignment, const Eigen::Matrix3d& covariance_E) {
  return spatial::rotate_covariance(world_from_east_north(alignment), covariance_E);
}

Eigen::Matrix3d covariance_of_fix(const Alignment& alignment, const Eigen::Matrix3d& covariance_W) {
  return spatial::rotate_covariance(world_from_east_north(alignment).transpose(), covariance_W);
}

}  // namespace nacelle::navsat
