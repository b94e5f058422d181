// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/slip.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::ekf {
namespace {

constexpr double kSlipSmoothing = 0.03;  // s; noise, and stamps that are a few milliseconds apart
constexpr double kForceSmoothing = 0.1;  // s
constexpr double kYawShare = 0.1;        // of the yaw rate: scale of the gyro, separation of the wheels
constexpr Duration kWitnessAge = 200ms;  // older readings are no witness
constexpr Duration kSlipHold = 200ms;    // slip comes and goes
// The observer: gap' = force error - follow * gap, offset' = -learn * gap. The slow one sees a wheel that spins up; the fast one
// takes a steady force for tilt, within a second.
struct Observer {
  double follow, learn;
};
constexpr Observer kSlow{2.0, 0.5};
constexpr Observer kFast{16.0, 16.0};
constexpr double kSteadyWheels = 0.3;  // m/s^2
constexpr double kRampForce = 2.0;     // m/s^2; a ramp of 12 degrees
// m/s^2; what tilt may add to the integral while the wheels cannot correct it.
constexpr double kTiltDrift = 0.1;
constexpr double kForgiven = 0.25;

}  // namespace

void Slip::see_imu(WallTime stamp, const Witness& imu, double yaw_rate_rps) {
  const Duration since = stamp - last_imu;
  if (since <= 0ns && last_imu != WallTime{}) return;  // late
  last_imu = stamp;
  has_force = imu.has_force;
  if (since > kWitnessAge) {
    gyro_rps = yaw_rate_rps;
    force_mps2 = imu.linear[0] - offset_mps2;
    last_wheels = {};
    return;
  }
  const double dt_s = to_seconds(since);
  gyro_rps += dt_s / (dt_s + kSlipSmoothing) * (yaw_rate_rps - gyro_rps);
  speed_mps += (imu.linear[0] - offset_mps2) * dt_s;
  force_mps2 += dt_s / (dt_s + kForceSmoothing) * (imu.linear[0] - offset_mps2 - force_mps2);
}

void Slip::follow_wheels(double speed, double dt_s) {
  const bool steady = std::abs(wheels_mps2) < kSteadyWheels && std::abs(force_mps2) < kRampForce;
  const Observer& how = steady ? kFast : kSlow;
  const double gap = speed - speed_mps;
  speed_mps += std::min(1.0, how.follow * dt_s) * gap;
  offset_mps2 -= how.learn * dt_s * gap;
}

// Says whether the IMU is believed. Both wheels of one axle cannot slip for most of the time.
void Slip::judge_witness(bool differs, double dt_s, const SlipOptions& options) {
  const double most = to_seconds(options.longest);
  disagreement_s = std::clamp(disagreement_s + (differs ? dt_s : -kForgiven * dt_s), 0.0, most);
  if (disagreement_s <= 0.0) {
    armed = true;
    distrusts_imu = false;
  } else if (disagreement_s >= most && !distrusts_imu) {
    armed = false;
    distrusts_imu = true;
    ++distrusted;
  }
}

Doubt Slip::see_wheels(WallTime stamp, const Witness& wheels, const SlipOptions& options) {
  const Duration since = stamp - last_wheels;
  const bool begins = last_wheels == WallTime{} || since > kWitnessAge;
  if (since <= 0ns && !begins) return {};
  const bool has_imu = last_imu != WallTime{} && stamp - last_imu <= kWitnessAge && last_imu - stamp <= kWitnessAge;
  const double speed = wheels.linear[0];
  if (!std::isfinite(speed) || !std::isfinite(wheels.angular[2])) return {};
  last_wheels = stamp;
  if (begins || !has_imu) {
    speed_mps = wheels_mps = speed;
    yaw_gap_rps = wheels_mps2 = 0.0;
    slipping = false;
    speed_since = {};
    return {};
  }
  const double dt_s = to_seconds(since);
  yaw_gap_rps += dt_s / (dt_s + kSlipSmoothing) * (wheels.angular[2] - gyro_rps - yaw_gap_rps);
  wheels_mps2 += dt_s / (dt_s + kForceSmoothing) * ((speed - wheels_mps) / dt_s - wheels_mps2);
  wheels_mps = speed;
  if (!has_force) speed_mps = speed;
  speed_gap_mps = speed - speed_mps;
  const double alone_s = speed_since == WallTime{} ? 0.0 : to_seconds(stamp - speed_since);
  const bool yaw_differs = std::abs(yaw_gap_rps) > options.yaw_rate_rps + kYawShare * std::abs(gyro_rps);
  const bool speed_differs = std::abs(speed_gap_mps) > options.speed_mps + kTiltDrift * alone_s;
  judge_witness(yaw_differs || speed_differs, dt_s, options);

  if (armed && (yaw_differs || speed_differs)) differed = stamp;
  const bool slips = armed && differed != WallTime{} && stamp - differed <= kSlipHold;
  if (slips && !slipping) ++episodes;
  slipping = slips;
  if (slips && speed_differs && speed_since == WallTime{}) speed_since = stamp;
  if (!speed_differs || !slips) speed_since = {};
  if (!slips) {
    follow_wheels(speed, dt_s);
    return {};
  }
  ++inflated;
  const double yaw_rate = options.inflation * std::abs(yaw_gap_rps);
  const double one_wheel = options.inflation * 0.5 * options.wheel_separation_m * std::abs(yaw_gap_rps);
  const double both = options.inflation * std::abs(speed_gap_mps);
  return {.speed_mps2 = one_wheel * one_wheel + both * both, .yaw_rate_rps2 = yaw_rate * yaw_rate};
}

void Slip::forget_times() {
  last_imu = last_wheels = differed = speed_since = {};
  slipping = false;
}

}  // namespace nacelle::ekf
