// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/model/madgwick_filter.hpp"

#include <cmath>

namespace nacelle::imu_filter {
namespace {

// The squared distance F = |R^T d - s|^2 of a world direction d, seen from the sensor, and its measurement s has the
// gradient -4 (d q f) with f = R^T d - s: F's derivative is 2 f.(q* d q)', and f.(q* d q) = -<q, d q f> with d q f linear and
// symmetric in q. Only its direction is used, so -(d q f) is as good.
Eigen::Vector4d gradient(const Eigen::Quaterniond& q, const Eigen::Vector3d& expected_W,
                         const Eigen::Vector3d& seen_S) {
  const Eigen::Vector3d f = q.conjugate() * expected_W - seen_S;
  const Eigen::Quaterniond d{0.0, expected_W.x(), expected_W.y(), expected_W.z()};
  return -(d * q * Eigen::Quaterniond{0.0, f.x(), f.y(), f.z()}).coeffs();
}

}  // namespace

void MadgwickFilter::correct(const Measurement& measurement) {
  const double force = measurement.acceleration_mps2.norm();
  if (!(force > 0.0)) return;
  Eigen::Vector4d descent = gradient(R_WS_, world_.up, measurement.acceleration_mps2 / force);
  const bool has_field = measurement.magnetic_field && measurement.magnetic_field->norm() > 0.0;
  if (has_field) {
    const Eigen::Vector3d seen_S = measurement.magnetic_field->normalized();
    const Eigen::Vector3d field_W = R_WS_ * seen_S;
    const double upright = field_W.dot(world_.up);
    const double level = std::sqrt(std::max(0.0, 1.0 - upright * upright));
    descent += gradient(R_WS_, level * world_.north + upright * world_.up, seen_S);
  }
  const double length = descent.norm();
  // At the minimum there is no direction to go.
  if (!(length > 1e-12)) return;
  descent /= length;
  if (has_field && settings_.zeta != 0.0) {
    const Eigen::Quaterniond error = R_WS_.conjugate() * Eigen::Quaterniond{descent};
    bias_rps_ += 2.0 * settings_.zeta * measurement.dt_s * error.vec();
  }
  R_WS_.coeffs() -= settings_.gain * measurement.dt_s * descent;
}

}  // namespace nacelle::imu_filter
