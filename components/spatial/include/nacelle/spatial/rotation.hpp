// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "nacelle/spatial/angles.hpp"

namespace nacelle::spatial {

/// Fixed-axis roll, pitch, yaw (REP 103): turn about X, then Y, then Z of the frame that does not move.
struct RollPitchYaw {
  double roll_rad{};
  double pitch_rad{};  ///< [-pi/2, pi/2] when it comes from a rotation.
  double yaw_rad{};
};

[[nodiscard]] inline Eigen::Quaterniond quaternion_from_yaw(double yaw_rad) {
  return {std::cos(0.5 * yaw_rad), 0.0, 0.0, std::sin(0.5 * yaw_rad)};
}

/// Heading of the rotated x axis in the xy plane, in (-pi, pi].
[[nodiscard]] inline double yaw_from_quaternion(const Eigen::Quaterniond& q) {
  return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()),
                    q.w() * q.w() + q.x() * q.x() - q.y() * q.y() - q.z() * q.z());
}

[[nodiscard]] inline Eigen::Quaterniond quaternion_from_rpy(const RollPitchYaw& a) {
  const double cr = std::cos(0.5 * a.roll_rad), sr = std::sin(0.5 * a.roll_rad);
  const double cp = std::cos(0.5 * a.pitch_rad), sp = std::sin(0.5 * a.pitch_rad);
  const double cy = std::cos(0.5 * a.yaw_rad), sy = std::sin(0.5 * a.yaw_rad);
  return {cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
          cr * cp * sy - sr * sp * cy};
}

/// R = Rz(yaw) Ry(pitch) Rx(roll).
[[nodiscard]] inline Eigen::Matrix3d matrix_from_rpy(const RollPitchYaw& a) {
  const double cr = std::cos(a.roll_rad), sr = std::sin(a.roll_rad);
  const double cp = std::cos(a.pitch_rad), sp = std::sin(a.pitch_rad);
  const double cy = std::cos(a.yaw_rad), sy = std::sin(a.yaw_rad);
  Eigen::Matrix3d R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return R;
}

/// The angles of a unit quaternion. At pitch = +-pi/2 roll and yaw turn about one axis: roll is then 0 by choice.
[[nodiscard]] inline RollPitchYaw rpy_from_quaternion(const Eigen::Quaterniond& q) {
  const double sin_pitch = std::clamp(2.0 * (q.w() * q.y() - q.z() * q.x()), -1.0, 1.0);
  // Within 1e-6 rad of the pole (1 - sin < 5e-13) the two atan2 below divide rounding by rounding.
  if (std::abs(sin_pitch) > 1.0 - 5e-13) {
    const double twice = 2.0 * std::atan2(q.z(), q.w());
    return {0.0, std::copysign(0.5 * kPi, sin_pitch), wrap_to_pi(twice)};
  }
  return {std::atan2(2.0 * (q.w() * q.x() + q.y() * q.z()), 1.0 - 2.0 * (q.x() * q.x() + q.y() * q.y())),
          std::asin(sin_pitch),
          std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()), 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z()))};
}

/// The matrix S with S * v = w x v.
[[nodiscard]] inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& w) {
  Eigen::Matrix3d S;
  S << 0.0, -w.z(), w.y(), w.z(), 0.0, -w.x(), -w.y(), w.x(), 0.0;
  return S;
}

namespace detail {
// sin(r a) / sin(a) as a series in c = cos(a) - 1; term i has (u r^2 - v) c with u = 1/(i (2i+1)), v = i/(2i+1).
// Four terms: the remainder is below (|c|/2)^5, under 1e-16 for |c| < 1e-3.
[[nodiscard]] inline double near_slerp_weight(double ratio, double c) {
  const double square = ratio * ratio;
  double sum = 1.0 + (square * (1.0 / 36.0) - 4.0 / 9.0) * c;
  sum = 1.0 + (square * (1.0 / 21.0) - 3.0 / 7.0) * c * sum;
  sum = 1.0 + (square * (1.0 / 10.0) - 2.0 / 5.0) * c * sum;
  sum = 1.0 + (square * (1.0 / 3.0) - 1.0 / 3.0) * c * sum;
  return ratio * sum;
}
}  // namespace detail

/// Interpolates along the shorter great arc: `from` at ratio 0, `to` at ratio 1. Both must be unit quaternions.
///
/// Allocates: nothing.
/// Source:    Eberly, "A Fast and Accurate Algorithm for Computing SLERP" (2011), for neighbours within 0.089 rad,
///            where four terms leave less than 1e-16; sines elsewhere.
[[nodiscard]] inline Eigen::Quaterniond slerp(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to,
                                              double ratio) {
  double cosine = from.dot(to);
  const double sign = cosine < 0.0 ? -1.0 : 1.0;  // q and -q are one rotation; take the nearer
  cosine *= sign;
  double keep = 0.0;
  double take = 0.0;
  if (cosine > 0.999) {
    keep = detail::near_slerp_weight(1.0 - ratio, cosine - 1.0);
    take = detail::near_slerp_weight(ratio, cosine - 1.0);
  } else {
    const double angle = std::acos(std::min(cosine, 1.0));
    const double scale = 1.0 / std::sin(angle);
    keep = std::sin((1.0 - ratio) * angle) * scale;
    take = std::sin(ratio * angle) * scale;
  }
  return Eigen::Quaterniond{keep * from.coeffs() + (sign * take) * to.coeffs()};
}

}  // namespace nacelle::spatial
