// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "calibration_commands/model/lever_fit.hpp"

namespace nacelle::calibration {

inline constexpr double kHalfCircle_rad = std::numbers::pi;
inline constexpr double kDegree_rad = kHalfCircle_rad / 180.0;

/// An IMU on a base, and what both are asked to do.
struct Drive {
  double yaw_rad = 0.0, x_m = 0.0, y_m = 0.0;  // how the IMU sits
  double radius_m = 0.4, rate_rps = 1.0;       // of the circles
  int circles = 4;
  bool is_one_way = false;  // else they alternate
  double gyro_sign = 1.0, accel_scale = 1.0;
  double tilt_mps2 = 0.1;  // gravity along x, of a floor that is not level
  std::uint64_t seed = 1;
};

struct Series {
  std::vector<PlanarReading> readings;
  std::vector<Progress> wheels;
};

/// Ramps of a second up and down; the IMU at 100 Hz with a WT901's noise, the wheels at 50 Hz with counts of 0.144 mm, 8 ms late, and
/// stamps that jitter by 1 ms.
inline Series driven(const Drive& d) {
  std::mt19937_64 draws{d.seed};
  std::normal_distribution<double> normal;
  Series series;
  const double dt = 0.001;
  const double ramp_s = 1.0, steady_s = std::max(0.0, 2.0 * kHalfCircle_rad / d.rate_rps - ramp_s), pause_s = 0.8;
  const double leg_s = 2.0 * ramp_s + steady_s + pause_s;
  double distance = 0.0, yaw = 0.0, t = 0.0, rate_before = 0.0, speed_before = 0.0;
  for (int step = 0; t < leg_s * d.circles; ++step) {
    t = step * dt;
    const int leg = static_cast<int>(t / leg_s);
    const double in_leg = t - leg * leg_s;
    const double share = std::clamp(std::min(in_leg, 2.0 * ramp_s + steady_s - in_leg) / ramp_s, 0.0, 1.0);
    const double rate = (d.is_one_way || leg % 2 == 0 ? 1.0 : -1.0) * d.rate_rps * share;
    const double speed = d.radius_m * d.rate_rps * share;
    distance += speed * dt;
    yaw += rate * dt;
    const double alpha = (rate - rate_before) / dt, forward = (speed - speed_before) / dt;
    rate_before = rate;
    speed_before = speed;
    if (step % 10 == 0) {
      const double ahead = forward - alpha * d.y_m - rate * rate * d.x_m;
      const double left = speed * rate + alpha * d.x_m - rate * rate * d.y_m;
      const double c = std::cos(d.yaw_rad), s = std::sin(d.yaw_rad);
      series.readings.push_back({t, d.gyro_sign * rate + 0.0017 * normal(draws),
                                 d.accel_scale * (c * ahead + s * left) + d.tilt_mps2 + 0.02 * normal(draws),
                                 d.accel_scale * (c * left - s * ahead) - 0.03 + 0.02 * normal(draws)});
    }
    if (step % 20 == 7) {
      const auto counted = [](double metres) { return 0.000144 * std::floor(metres / 0.000144); };
      const double left = counted(distance - 0.15 * yaw), right = counted(distance + 0.15 * yaw);
      series.wheels.push_back({t + 0.008 + 0.001 * normal(draws), 0.5 * (left + right), (right - left) / 0.3});
    }
  }
  return series;
}

}  // namespace nacelle::calibration
