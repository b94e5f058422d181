// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/model/complementary_filter.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::imu_filter {
namespace {

constexpr double kGravityMps2 = 9.80665;

Eigen::Quaterniond about(const Eigen::Vector3d& axis, double angle_rad) {
  return Eigen::Quaterniond{Eigen::AngleAxisd{angle_rad, axis}};
}

}  // namespace

bool ComplementaryFilter::is_at_rest(const Measurement& measurement) {
  const auto& rate = measurement.angular_velocity_rps;
  const bool is_steady = std::abs(measurement.acceleration_mps2.norm() - kGravityMps2) <= kRestAcceleration &&
                         (rate - resting_rps_).cwiseAbs().maxCoeff() <= kRestRateChange &&
                         (rate - bias_rps_).cwiseAbs().maxCoeff() <= kRestRate;
  if (is_steady) {
    rested_s_ += measurement.dt_s;
  } else {
    rested_s_ = 0.0;
    resting_rps_ = rate;
  }
  return rested_s_ >= kRestTime;
}

void ComplementaryFilter::correct(const Measurement& measurement) {
  if (settings_.do_bias_estimation && is_at_rest(measurement)) {
    bias_rps_ += settings_.bias_alpha * (measurement.angular_velocity_rps - bias_rps_);
  }
  const double force = measurement.acceleration_mps2.norm();
  if (!(force > 0.0)) return;
  double gain = settings_.gain_acc;
  // Full below 0.1 g of acceleration, nothing above 0.2 g (section 5.3).
  if (settings_.do_adaptive_gain) gain *= std::clamp(2.0 - std::abs(force / kGravityMps2 - 1.0) / 0.1, 0.0, 1.0);
  const Eigen::Vector3d up_W = R_WS_ * (measurement.acceleration_mps2 / force);
  const Eigen::Vector3d axis = up_W.cross(world_.up);
  // Exactly upside down there is no shortest way: the next measurement has one.
  if (const double sine = axis.norm(); sine > 1e-12) {
    R_WS_ = about(axis / sine, gain * std::atan2(sine, up_W.dot(world_.up))) * R_WS_;
  }
  if (!measurement.magnetic_field) return;
  const Eigen::Vector3d field_W = R_WS_ * *measurement.magnetic_field;
  const double to_north = std::atan2(field_W.cross(world_.north).dot(world_.up), field_W.dot(world_.north));
  R_WS_ = about(world_.up, settings_.gain_mag * to_north) * R_WS_;
}

}  // namespace nacelle::imu_filter
