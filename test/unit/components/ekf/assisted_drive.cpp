// SPDX-License-Identifier: Apache-2.0
#include "assisted_drive.hpp"

#include <algorithm>
#include <numbers>

#include "ekf/model/covariance_parameter.hpp"
#include "simulation/model/random.hpp"

namespace nacelle::ekf {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kWheelSpeedStddev = 0.01, kWheelYawRateStddev = 0.05, kGyroStddev = 0.003;
constexpr double kAccelerationStddev = 0.05, kAccelerationBiasStddev = 0.03;
constexpr double kAcceleration = 1.0, kYawAcceleration = 3.0;  // what the motors do
enum Part : std::uint16_t { kWheels, kGyro, kForce, kParts };

double approach(double value, double target, double most) { return value + std::clamp(target - value, -most, most); }

}  // namespace

DriveResult drive(const DriveCase& how, const AssistOptions& assists, std::uint64_t seed) {
  simulation::Random constants{seed, 1}, noise{seed, 2};
  const double bias = how.gyro_bias_rps + constants.normal(how.gyro_bias_stddev_rps);
  const double separation = 1.0 + how.separation_error + constants.normal(how.separation_error_stddev);
  const double force_bias = constants.normal(kAccelerationBiasStddev);

  FilterOptions options;
  options.process_noise = ProcessNoise{default_process_noise()};
  options.initial.covariance = default_initial_covariance();
  options.sensor_timeout = options.period = 20ms;
  options.two_d_mode = true;
  options.parts = kParts;
  options.assists = assists;
  options.assists.gyro_bias.yaw_only = options.assists.standstill.two_d = true;
  Filter filter{options};

  double x = 0.0, y = 0.0, yaw = 0.0, speed = 0.0, yaw_rate = 0.0, before = 0.0;
  double yaw_error = 0.0, yaw_squares = 0.0, position_squares = 0.0;
  int steps = 0;
  DriveResult result;
  const auto offer = [&](std::uint16_t part, WallTime stamp, const Witness& witness, auto&& rows) {
    filter.offer(part, stamp, stamp, [&](Reading& r) -> Prepared {
      r.rows = 0;
      r.gate = std::numeric_limits<double>::infinity();
      rows(r);
      for (const StateIndex flat : {kZ, kRoll, kPitch, kVz, kVroll, kVpitch, kAz}) r.add(flat, 0.0, 1e-6);
      r.witness = witness;
      return {};
    });
  };
  constexpr double kDt = 0.01;
  const int last = static_cast<int>(how.duration_s / kDt);
  for (int i = 1; i <= last; ++i) {
    const double t = i * kDt;
    const auto [aim_speed, aim_yaw_rate] = how.command(t);
    const Upset upset = how.upset(t);
    speed = approach(speed, aim_speed, kAcceleration * kDt);
    yaw_rate = approach(yaw_rate, aim_yaw_rate, kYawAcceleration * kDt);
    const double v = speed + upset.body_speed, w = yaw_rate + upset.body_yaw_rate;
    const double acceleration = (v - before) / kDt;
    before = v;
    x += v * kDt * std::cos(yaw + 0.5 * w * kDt);
    y += v * kDt * std::sin(yaw + 0.5 * w * kDt);
    yaw += w * kDt;

    const WallTime stamp{1000s + i * 10ms};
    const double gyro = how.gyro_scale * w + bias + noise.normal(how.gyro_noise_rps);
    const double force =
        acceleration + kGravity * std::sin(upset.tilt_rad) + force_bias + noise.normal(kAccelerationStddev);
    Witness imu{.source = Witness::Source::Imu, .linear = {force, 0.0, kGravity}, .angular = {0.0, 0.0, gyro}};
    offer(kGyro, stamp, imu, [&](Reading& r) { r.add(kVyaw, gyro, kGyroStddev * kGyroStddev); });
    if (how.acceleration) {
      offer(kForce, stamp, {}, [&](Reading& r) { r.add(kAx, force, kAccelerationStddev * kAccelerationStddev); });
    }
    if (i % 2 != 0) continue;
    // Wheels at rest say zero: an encoder has no noise then.
    const bool turn =
        std::abs(speed) + std::abs(yaw_rate) + std::abs(upset.wheel_speed) + std::abs(upset.wheel_yaw_rate) > 0.0;
    const double wheel_speed = turn ? speed + upset.wheel_speed + noise.normal(0.003) : 0.0;
    const double wheel_yaw_rate = turn ? separation * (yaw_rate + upset.wheel_yaw_rate) + noise.normal(0.01) : 0.0;
    Witness wheels{.source = Witness::Source::Wheels,
                   .teaches_bias = how.wheels_teach_bias,
                   .linear = {wheel_speed, 0.0, 0.0},
                   .angular = {0.0, 0.0, wheel_yaw_rate}};
    offer(kWheels, stamp, wheels, [&](Reading& r) {
      r.add(kVx, wheel_speed, kWheelSpeedStddev * kWheelSpeedStddev);
      r.add(kVy, 0.0, kWheelSpeedStddev * kWheelSpeedStddev);
      if (how.wheels_yaw_rate) r.add(kVyaw, wheel_yaw_rate, kWheelYawRateStddev * kWheelYawRateStddev);
    });
    filter.step(stamp);
    const StateVector& mean = filter.belief().mean;
    yaw_error += spatial::wrap_to_pi(mean[kYaw] - yaw - yaw_error);  // not wrapped: it may be more than a turn
    yaw_squares += yaw_error * yaw_error;
    position_squares += (mean[kX] - x) * (mean[kX] - x) + (mean[kY] - y) * (mean[kY] - y);
    ++steps;
    result.yaw_end_deg = std::abs(yaw_error) * 180.0 / std::numbers::pi;
  }
  result.yaw_rms_deg = std::sqrt(yaw_squares / steps) * 180.0 / std::numbers::pi;
  result.position_rms_m = std::sqrt(position_squares / steps);
  result.state = filter.assists();
  result.bias_error_rps = std::abs(result.state.gyro_bias.mean_rps.z() - bias);
  return result;
}

DriveResult drive_all_seeds(const DriveCase& how, const AssistOptions& assists) {
  DriveResult all;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const DriveResult one = drive(how, assists, seed);
    all.yaw_rms_deg += one.yaw_rms_deg * one.yaw_rms_deg;
    all.yaw_end_deg += one.yaw_end_deg * one.yaw_end_deg;
    all.position_rms_m += one.position_rms_m * one.position_rms_m;
    all.bias_error_rps += one.bias_error_rps * one.bias_error_rps;
    all.state = one.state;
  }
  for (double* const sum : {&all.yaw_rms_deg, &all.yaw_end_deg, &all.position_rms_m, &all.bias_error_rps})
    *sum = std::sqrt(*sum / static_cast<double>(kSeeds));
  return all;
}

}  // namespace nacelle::ekf
