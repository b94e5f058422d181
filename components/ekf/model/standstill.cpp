// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/standstill.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacelle::ekf {
namespace {

constexpr double kRestSmoothing = 0.05;  // s; takes the noise off single readings
constexpr double kRestTime = 2.0;        // s; what is usual at rest; follows the bias as it drifts
constexpr Duration kImuGap = 200ms;      // after a longer one the IMU begins anew

Eigen::Vector3d as_vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

void follow(Eigen::Vector3d& mean, const Eigen::Vector3d& value, double dt_s, double time_s) {
  mean += dt_s / (dt_s + time_s) * (value - mean);
}

}  // namespace

void Standstill::see_imu(WallTime stamp, const Witness& imu, double yaw_bias_rps, double bias_stddev_rps,
                         const StandstillOptions& options) {
  const Duration since = stamp - last_imu;
  if (since <= 0ns && last_imu != WallTime{}) return;  // late
  last_imu = stamp;
  const Eigen::Vector3d rate_now = as_vector(imu.angular);
  const Eigen::Vector3d force_now = as_vector(imu.linear);
  if (since > kImuGap) {
    rate = rate_now;
    force = force_now;
  } else {
    follow(rate, rate_now, to_seconds(since), kRestSmoothing);
    follow(force, force_now, to_seconds(since), kRestSmoothing);
  }
  if (still_since == WallTime{}) return;
  if (stamp - still_since < options.time * 4 / 5) {  // the body still rocks
    rate_at_rest = rate;
    force_at_rest = force;
    return;
  }
  const double limit_rps =
      bias_stddev_rps < 0.0 ? options.gyro_limit_rps
                            : std::min(options.gyro_limit_rps, 2.0 * options.gyro_change_rps + 3.0 * bias_stddev_rps);
  const bool moves = !(std::abs(rate.z() - yaw_bias_rps) <= limit_rps) ||
                     !((rate - rate_at_rest).cwiseAbs().maxCoeff() <= options.gyro_change_rps) ||
                     !((force - force_at_rest).norm() <= options.force_change_mps2);
  if (moves) {
    moved = stamp;
    standing = false;
    if (!contradicted) ++contradictions;
    contradicted = true;
    return;
  }
  follow(rate_at_rest, rate, to_seconds(std::min(since, kImuGap)), kRestTime);
  follow(force_at_rest, force, to_seconds(std::min(since, kImuGap)), kRestTime);
}

void Standstill::see_wheels(WallTime stamp, const Witness& wheels, const StandstillOptions& options) {
  if (stamp < last_wheels) return;
  last_wheels = stamp;
  // NaN is no standstill.
  const bool still = std::hypot(wheels.linear[0], wheels.linear[1]) <= options.speed_mps &&
                     std::abs(wheels.angular[2]) <= options.yaw_rate_rps;
  if (!still) {
    still_since = moved = {};
    standing = contradicted = false;
    return;
  }
  if (still_since == WallTime{}) still_since = stamp;
  const bool has_imu = last_imu != WallTime{} && stamp - last_imu <= kImuGap;
  if (!has_imu) contradicted = false;
  if (contradicted && stamp - moved >= options.time) contradicted = false;
  standing = stamp - still_since >= options.time && !contradicted;
}

void Standstill::forget_times() {
  still_since = moved = last_imu = last_wheels = {};
  standing = contradicted = false;
}

void write_zero_velocity(const StandstillOptions& options, Reading& out) {
  const double speed = options.speed_stddev_mps * options.speed_stddev_mps;
  const double rate = options.yaw_rate_stddev_rps * options.yaw_rate_stddev_rps;
  out.rows = 0;
  out.gate = std::numeric_limits<double>::infinity();
  out.add(kVx, 0.0, speed);
  out.add(kVy, 0.0, speed);
  if (!options.two_d) {
    out.add(kVz, 0.0, speed);
    out.add(kVroll, 0.0, rate);
    out.add(kVpitch, 0.0, rate);
  }
  out.add(kVyaw, 0.0, rate);
}

}  // namespace nacelle::ekf
