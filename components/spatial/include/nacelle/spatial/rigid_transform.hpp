// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "nacelle/spatial/rotation.hpp"

namespace nacelle::spatial {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A pose, kept as messages keep it. X_AB takes coordinates in B to coordinates in A.
struct RigidTransform {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();

  [[nodiscard]] static RigidTransform from(const Eigen::Isometry3d& X) {
    return {Eigen::Quaterniond{X.linear()}, X.translation()};
  }
  [[nodiscard]] static RigidTransform planar(double x_m, double y_m, double yaw_rad) {
    return {quaternion_from_yaw(yaw_rad), {x_m, y_m, 0.0}};
  }
  [[nodiscard]] Eigen::Isometry3d isometry() const {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = rotation.toRotationMatrix();
    X.translation() = translation_m;
    return X;
  }
  [[nodiscard]] RigidTransform inverse() const {
    const Eigen::Quaterniond back = rotation.conjugate();
    return {back, -(back * translation_m)};
  }
};

/// X_AC = X_AB * X_BC.
[[nodiscard]] inline RigidTransform operator*(const RigidTransform& X_AB, const RigidTransform& X_BC) {
  return {X_AB.rotation * X_BC.rotation, X_AB.translation_m + X_AB.rotation * X_BC.translation_m};
}
/// The point p, given in B, in A.
[[nodiscard]] inline Eigen::Vector3d operator*(const RigidTransform& X_AB, const Eigen::Vector3d& p_B) {
  return X_AB.translation_m + X_AB.rotation * p_B;
}

/// Lerp of the translation, slerp of the rotation.
[[nodiscard]] inline RigidTransform interpolate(const RigidTransform& from, const RigidTransform& to, double ratio) {
  return {slerp(from.rotation, to.rotation, ratio),
          from.translation_m + ratio * (to.translation_m - from.translation_m)};
}

/// Takes a twist of one body from B to A when both frames are fixed to that body.
///
/// Frame:  order as in messages: linear, then angular. v_A = R v_B + t x (R w_B), w_A = R w_B.
/// Source: Lynch and Park, Modern Robotics (2017), eq. 3.83, with the halves of the vector exchanged.
[[nodiscard]] inline Matrix6d adjoint(const RigidTransform& X_AB) {
  const Eigen::Matrix3d R = X_AB.rotation.toRotationMatrix();
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = R;
  Ad.bottomRightCorner<3, 3>() = R;
  Ad.topRightCorner<3, 3>() = cross_matrix(X_AB.translation_m) * R;
  return Ad;
}

/// R C R^T: a covariance given along the axes of B, along those of A.
[[nodiscard]] inline Eigen::Matrix3d rotate_covariance(const Eigen::Matrix3d& R_AB,
                                                       const Eigen::Matrix3d& covariance_B) {
  return R_AB * covariance_B * R_AB.transpose();
}
/// The same for (linear, angular), both halves turned by one rotation.
[[nodiscard]] inline Matrix6d rotate_covariance(const Eigen::Matrix3d& R_AB, const Matrix6d& covariance_B) {
  Matrix6d C;
  for (int i = 0; i < 6; i += 3) {
    for (int j = 0; j < 6; j += 3) {
      C.block<3, 3>(i, j).noalias() = R_AB * covariance_B.block<3, 3>(i, j) * R_AB.transpose();
    }
  }
  return C;
}

}  // namespace nacelle::spatial
