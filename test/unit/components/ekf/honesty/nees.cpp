// SPDX-License-Identifier: Apache-2.0
#include "nees.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "ekf/model/covariance_parameter.hpp"
#include "ekf/model/filter.hpp"

namespace nacelle::ekf::honesty {
namespace {

// Before a window, for the velocity to settle.
constexpr double kSettle_s = 1.0;

WallTime at(double t_s) { return WallTime{1000s} + from_seconds(t_s); }

FilterOptions options_of(const Setup& setup) {
  FilterOptions options;
  VehicleLimits limits = setup.limits;
  options.process_noise = ProcessNoise{setup.wheeled ? wheeled_process_noise(limits) : default_process_noise()};
  options.initial.covariance = default_initial_covariance();
  options.period = from_seconds(1.0 / setup.frequency_hz);
  options.sensor_timeout = options.period;
  options.two_d_mode = true;
  options.parts = 2;
  options.innovations.adaptive = {setup.adaptive, setup.adaptive};
  return options;
}

// As the odometry component writes it, with its defaults of twist_covariance_diagonal.
Matrix6d twist_covariance(const WheelReading& reading, double separation_m, const odometry::SlipModel& slip) {
  const odometry::StepVariance v = odometry::variance_of(reading.step, separation_m, slip);
  const double per_square = 1.0 / (reading.dt_s * reading.dt_s);
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << 1e-5 + v.along * per_square, 1e-5 + v.across * per_square, 1e-6, 1e-6, 1e-6,
      1e-4 + v.turn * per_square;
  return covariance;
}

void offer_wheels(Filter& filter, const Drive& drive, const WheelReading& reading, const Setup& setup) {
  Vector6d twist = Vector6d::Zero();
  twist[0] = 0.5 * (reading.step.left_m + reading.step.right_m) / reading.dt_s;
  twist[5] = (reading.step.right_m - reading.step.left_m) / drive.separation_m / reading.dt_s;
  PartSetup how{.mask = mask_of(kVx) | mask_of(kVy), .two_d = true};
  if (drive.gyro.empty()) how.mask = static_cast<StateMask>(how.mask | mask_of(kVyaw));
  filter.offer(0, at(reading.t_s), at(reading.t_s), [&](Reading& out) {
    return prepare_twist(twist, twist_covariance(reading, drive.separation_m, setup.slip), {}, Eigen::Vector3d::Zero(),
                         how, out);
  });
}

void offer_gyro(Filter& filter, const GyroReading& reading, const Setup& setup) {
  Vector6d twist = Vector6d::Zero();
  twist[5] = reading.yaw_rate_rps;
  const Matrix6d covariance = Matrix6d::Identity() * setup.gyro_stddev_rps * setup.gyro_stddev_rps;
  filter.offer(1, at(reading.t_s), at(reading.t_s), [&](Reading& out) {
    return prepare_twist(twist, covariance, {}, Eigen::Vector3d::Zero(), {.mask = mask_of(kVyaw), .two_d = true}, out);
  });
}

Eigen::Matrix3d planar(const Estimate& estimate) {
  Eigen::Matrix3d P;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) P(i, j) = estimate.covariance[i][j];
  }
  return P;
}

Eigen::Vector3d seen_from(double x, double y, double yaw, double dx, double dy, double dyaw) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * (dx - x) + s * (dy - y), -s * (dx - x) + c * (dy - y), dyaw - yaw};
}

}  // namespace

Setup default_robot() {
  Setup setup;
  setup.limits = {.speed_mps = 0.5,
                  .acceleration_mps2 = 1.0,
                  .yaw_rate_rps = 2.0,
                  .yaw_acceleration_rps2 = 4.0,
                  .interval_s = 0.02};
  return setup;
}

Setup outdoor_vehicle() {
  Setup setup;
  setup.limits = {.speed_mps = 2.0, .acceleration_mps2 = 1.0, .yaw_rate_rps = 1.0, .interval_s = 0.2};
  setup.slip = {.distance_m = 0.05, .lateral_m = 0.05, .heading_rad = 0.02, .turn_rad = 0.03};
  setup.frequency_hz = 10.0;
  return setup;
}

std::vector<Estimate> run(const Drive& drive, const Setup& setup) {
  return run(drive, setup, drive.truth.front().t_s, drive.truth.back().t_s);
}

std::vector<Estimate> run(const Drive& drive, const Setup& setup, double from_s, double to_s) {
  const auto known = drive.true_pose(from_s);
  if (!known || drive.wheels.empty()) return {};
  const TruePose start = *known;
  Filter filter{options_of(setup)};
  Reading pose;
  for (const auto& [state, value] :
       {std::pair{kX, start.x_m}, std::pair{kY, start.y_m}, std::pair{kYaw, start.yaw_rad}})
    pose.add(state, value, 1e-9);
  std::vector<Estimate> estimates;
  if (!filter.set_pose(pose, at(start.t_s))) return estimates;
  const auto after = [&](const auto& readings) {
    return static_cast<std::size_t>(
        std::ranges::find_if(readings, [&](const auto& reading) { return reading.t_s > from_s; }) - readings.begin());
  };
  std::size_t wheel = after(drive.wheels), gyro = after(drive.gyro);
  double unwrapped = start.yaw_rad;
  const double end_s = std::min(to_s, drive.wheels.back().t_s), period_s = 1.0 / setup.frequency_hz;
  for (int i = 1; start.t_s + i * period_s <= end_s + 1e-9; ++i) {
    const double now_s = start.t_s + i * period_s;
    for (; wheel < drive.wheels.size() && drive.wheels[wheel].t_s <= now_s; ++wheel)
      offer_wheels(filter, drive, drive.wheels[wheel], setup);
    for (; gyro < drive.gyro.size() && drive.gyro[gyro].t_s <= now_s; ++gyro)
      offer_gyro(filter, drive.gyro[gyro], setup);
    filter.step(at(now_s), MonotonicTime{} + 1s + from_seconds(now_s - start.t_s));
    const auto output = filter.output(at(now_s));
    if (!output) continue;
    const auto truth = drive.true_pose(to_seconds(output->stamp - at(0.0)));
    if (!truth) continue;
    const StateVector& x = output->belief->mean;
    unwrapped += std::remainder(x[kYaw] - unwrapped, 2.0 * M_PI);
    Estimate& e = estimates.emplace_back();
    e.truth = *truth;
    e.x_m = x[kX];
    e.y_m = x[kY];
    e.yaw_rad = unwrapped;
    constexpr int kRows[3] = {kX, kY, kYaw};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) e.covariance[r][c] = output->belief->covariance(kRows[r], kRows[c]);
    }
  }
  return estimates;
}

Motion motion_between(const Estimate& begin, const Estimate& end) {
  const Eigen::Vector3d told = seen_from(begin.x_m, begin.y_m, begin.yaw_rad, end.x_m, end.y_m, end.yaw_rad);
  const Eigen::Vector3d real =
      seen_from(begin.truth.x_m, begin.truth.y_m, begin.truth.yaw_rad, end.truth.x_m, end.truth.y_m, end.truth.yaw_rad);
  Eigen::Matrix3d F = Eigen::Matrix3d::Identity();
  F(0, 2) = -(end.y_m - begin.y_m);
  F(1, 2) = end.x_m - begin.x_m;
  Eigen::Matrix3d back = Eigen::Matrix3d::Identity();  // G^-1
  const double c = std::cos(begin.yaw_rad), s = std::sin(begin.yaw_rad);
  back.topLeftCorner<2, 2>() << c, s, -s, c;
  const Eigen::Matrix3d grown = planar(end) - F * planar(begin) * F.transpose();
  const Eigen::Matrix3d C = back * grown * back.transpose();
  Motion motion;
  for (int i = 0; i < 3; ++i) {
    motion.error[i] = real[i] - told[i];
    for (int j = 0; j < 3; ++j) motion.covariance[i][j] = C(i, j);
  }
  return motion;
}

WindowErrors relative_errors(const Drive& drive, const Setup& setup, double window_s) {
  WindowErrors errors;
  const double end_s = drive.truth.back().t_s;
  for (double begin_s = drive.truth.front().t_s + kSettle_s; begin_s + window_s <= end_s; begin_s += window_s) {
    const std::vector<Estimate> estimates = run(drive, setup, begin_s - kSettle_s, begin_s + window_s);
    const auto begin =
        std::ranges::find_if(estimates, [&](const Estimate& e) { return e.truth.t_s >= begin_s - 1e-6; });
    if (begin == estimates.end() || estimates.back().truth.t_s - begin->truth.t_s < 0.9 * window_s) continue;
    const Motion m = motion_between(*begin, estimates.back());
    const Eigen::Vector2d e{m.error[0], m.error[1]};
    Eigen::Matrix2d C;
    C << m.covariance[0][0], m.covariance[0][1], m.covariance[1][0], m.covariance[1][1];
    errors.position.push_back(e.dot(C.inverse() * e));
    errors.position_m2 += e.squaredNorm();
    errors.yaw_rad2 += m.error[2] * m.error[2];
    errors.yaw.push_back(m.error[2] * m.error[2] / m.covariance[2][2]);
  }
  return errors;
}

Honesty honesty_of(const std::vector<double>& nees, int freedom) {
  Honesty honesty;
  // The 95 % quantiles of chi-squared with one and with two degrees of freedom.
  const double limit = freedom == 1 ? 3.841 : 5.991;
  for (const double value : nees) {
    honesty.mean += value / freedom / static_cast<double>(nees.size());
    honesty.coverage += value <= limit ? 1.0 / static_cast<double>(nees.size()) : 0.0;
  }
  return honesty;
}

Band band_of_mean(int runs, int freedom) {
  const double k = static_cast<double>(runs) * freedom, spread = std::sqrt(2.0 / (9.0 * k));
  const auto quantile = [&](double z) { return std::pow(1.0 - 2.0 / (9.0 * k) + z * spread, 3); };
  return {quantile(-1.959964), quantile(1.959964)};
}

}  // namespace nacelle::ekf::honesty
