// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/model/orientation_filter.hpp"

#include <cmath>

namespace nacelle::imu_filter {
namespace {

// Below this length a vector has no direction that numbers could tell.
constexpr double kLeastLength = 1e-12;
// A horizontal part below 1 % of the whole says nothing of the heading: 0.6 degrees of tilt are as large.
constexpr double kLeastHorizontal = 0.01;

Eigen::Vector3d horizontal(const Eigen::Vector3d& v, const Eigen::Vector3d& up) { return v - up * up.dot(v); }

// Columns: a horizontal direction, up, and what completes them.
Eigen::Matrix3d axes(const Eigen::Vector3d& along, const Eigen::Vector3d& up) {
  Eigen::Matrix3d columns;
  columns << along, up, along.cross(up);
  return columns;
}

}  // namespace

bool OrientationFilter::start(const Measurement& at_rest) {
  const double force = at_rest.acceleration_mps2.norm();
  if (!(force > kLeastLength)) return false;
  const Eigen::Vector3d up_S = at_rest.acceleration_mps2 / force;
  Eigen::Vector3d along_W = world_.north;
  Eigen::Vector3d along_S = Eigen::Vector3d::Zero();
  if (at_rest.magnetic_field) along_S = horizontal(*at_rest.magnetic_field, up_S) / at_rest.magnetic_field->norm();
  if (!(along_S.norm() > kLeastHorizontal)) {
    along_W = Eigen::Vector3d::UnitX();
    along_S = horizontal(Eigen::Vector3d::UnitX(), up_S);
    // With x upright, z takes its part: heading is then a matter of choice.
    if (along_S.norm() < kLeastHorizontal) along_S = horizontal(Eigen::Vector3d::UnitZ(), up_S);
  }
  R_WS_ = Eigen::Quaterniond{axes(along_W, world_.up) * axes(along_S.normalized(), up_S).transpose()};
  R_WS_.normalize();
  last_rps_ = at_rest.angular_velocity_rps;
  return true;
}

void OrientationFilter::start_at(const Eigen::Quaterniond& R_WS) {
  R_WS_ = R_WS.normalized();
  last_rps_.reset();
}

void OrientationFilter::level(const Eigen::Vector3d& acceleration_mps2) {
  last_rps_.reset();
  if (!(acceleration_mps2.norm() > kLeastLength)) return;
  const Eigen::Vector3d up_W = R_WS_ * acceleration_mps2.normalized();
  R_WS_ = (Eigen::Quaterniond::FromTwoVectors(up_W, world_.up) * R_WS_).normalized();
}

void OrientationFilter::turn(const Eigen::Vector3d& angular_velocity_rps, double dt_s) {
  const double rate = angular_velocity_rps.norm();
  const double half = 0.5 * rate * dt_s;
  // sin(half)/rate, and its limit where the rate vanishes.
  const double scale = rate * dt_s > 1e-9 ? std::sin(half) / rate : 0.5 * dt_s;
  const Eigen::Vector3d v = scale * angular_velocity_rps;
  R_WS_ = R_WS_ * Eigen::Quaterniond{std::cos(half), v.x(), v.y(), v.z()};
}

void OrientationFilter::update(const Measurement& measurement) {
  const Eigen::Vector3d mean_rps =
      0.5 * (measurement.angular_velocity_rps + last_rps_.value_or(measurement.angular_velocity_rps));
  turn(mean_rps - bias_rps_, measurement.dt_s);
  correct(measurement);
  R_WS_.normalize();
  last_rps_ = measurement.angular_velocity_rps;
}

}  // namespace nacelle::imu_filter
