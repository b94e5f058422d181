// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/lever_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

namespace nacelle::calibration {
namespace {

constexpr double kHalfCircle_rad = std::numbers::pi;
constexpr double kDegree_rad = kHalfCircle_rad / 180.0;

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
Series driven(const Drive& d) {
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

std::optional<LeverFault> fault_of(const Drive& drive) {
  const Series series = driven(drive);
  const auto fit = fit_lever(series.readings, series.wheels);
  return fit ? std::optional<LeverFault>{} : fit.error();
}

TEST(LeverFit, two_eights_show_yaw_and_lever_arm_to_half_a_degree_and_a_centimetre) {
  const Drive mounted[] = {
      {}, {0.1, 0.12, -0.05}, {-1.2, -0.2, 0.1}, {kHalfCircle_rad / 2, 0.05, 0.08}, {3.0, -0.07, -0.11}};
  for (std::uint64_t seed = 1; seed <= 11; ++seed) {
    for (Drive drive : mounted) {
      drive.seed = seed;
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", yaw " << drive.yaw_rad);
      const Series series = driven(drive);
      const auto fit = fit_lever(series.readings, series.wheels);
      ASSERT_TRUE(fit) << static_cast<int>(fit.error());
      EXPECT_NEAR(std::remainder(fit->yaw_rad - drive.yaw_rad, 2.0 * kHalfCircle_rad), 0.0, 0.5 * kDegree_rad);
      EXPECT_NEAR(fit->x_m, drive.x_m, 0.01);
      EXPECT_NEAR(fit->y_m, drive.y_m, 0.01);
      EXPECT_NEAR(fit->scale, 1.0, 0.1);
    }
  }
}

TEST(LeverFit, its_own_uncertainty_covers_its_errors) {
  int inside = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Drive drive{0.3, 0.1, 0.05};
    drive.seed = seed;
    const Series series = driven(drive);
    const auto fit = fit_lever(series.readings, series.wheels);
    ASSERT_TRUE(fit) << "seed " << seed;
    for (const double off : {(fit->yaw_rad - drive.yaw_rad) / fit->yaw_stddev_rad,
                             (fit->x_m - drive.x_m) / fit->x_stddev_m, (fit->y_m - drive.y_m) / fit->y_stddev_m}) {
      ++all;
      inside += std::abs(off) < 2.5 ? 1 : 0;
    }
  }
  EXPECT_GT(inside, all * 8 / 10) << inside << " of " << all;
}

TEST(LeverFit, a_drive_that_does_not_show_it_is_refused_with_the_reason) {
  EXPECT_EQ(fit_lever({}, {}).error(), LeverFault::TooFew);
  EXPECT_EQ(fault_of({.circles = 1}), LeverFault::TooFew);
  EXPECT_EQ(fault_of({.rate_rps = 0.2}), LeverFault::HardlyTurned);
  EXPECT_EQ(fault_of({.is_one_way = true}), LeverFault::OneWay);
  EXPECT_EQ(fault_of({.gyro_sign = -1.0}), LeverFault::GyroDisagrees);
  EXPECT_EQ(fault_of({.gyro_sign = 1.5}), LeverFault::GyroDisagrees);
  EXPECT_EQ(fault_of({.radius_m = 0.02}), LeverFault::HardlyDriven);
  EXPECT_EQ(fault_of({.accel_scale = 0.1}), LeverFault::Mismatch);
  EXPECT_EQ(fault_of({.accel_scale = -1.0}), std::nullopt) << "turned by 180 degrees: a yaw like any other";
}

TEST(LeverFit, readings_with_gaps_are_left_out) {
  Series series = driven({.yaw_rad = 0.2, .x_m = 0.1, .y_m = 0.02, .circles = 6});
  std::erase_if(series.readings, [](const PlanarReading& r) { return std::fmod(r.stamp_s, 3.0) < 0.5; });
  const auto fit = fit_lever(series.readings, series.wheels);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->yaw_rad, 0.2, 0.5 * kDegree_rad);
  EXPECT_NEAR(fit->x_m, 0.1, 0.01);
}

// The figures of docs/ekf.md.
TEST(LeverFitFigures, errors_over_44_seeds) {
  struct Case {
    int eights;
    double rate_rps, radius_m;
  };
  std::printf("%-28s %-16s %-16s of 44\n", "RMS, worst", "yaw in degrees", "lever arm in mm");
  for (const auto& [eights, rate_rps, radius_m] : {Case{1, 1.5, 0.3}, {2, 1.0, 0.4}, {2, 1.5, 0.3}, {4, 1.5, 0.3}}) {
    double yaw_squares = 0.0, lever_squares = 0.0, yaw_worst = 0.0, lever_worst = 0.0;
    int found = 0;
    for (std::uint64_t seed = 1; seed <= 44; ++seed) {
      const Drive drive{.yaw_rad = 0.1,
                        .x_m = 0.12,
                        .y_m = -0.05,
                        .radius_m = radius_m,
                        .rate_rps = rate_rps,
                        .circles = 2 * eights,
                        .seed = seed};
      const Series series = driven(drive);
      const auto fit = fit_lever(series.readings, series.wheels);
      if (!fit) continue;
      ++found;
      const double yaw = (fit->yaw_rad - drive.yaw_rad) / kDegree_rad;
      const double lever = 1e3 * std::hypot(fit->x_m - drive.x_m, fit->y_m - drive.y_m);
      yaw_squares += yaw * yaw;
      lever_squares += lever * lever;
      yaw_worst = std::max(yaw_worst, std::abs(yaw));
      lever_worst = std::max(lever_worst, lever);
    }
    std::printf("%d eights, %.1f rad/s, %.1f m    %.3f, %-9.3f %.2f, %-10.2f %d\n", eights, rate_rps, radius_m,
                std::sqrt(yaw_squares / found), yaw_worst, std::sqrt(lever_squares / found), lever_worst, found);
    EXPECT_LT(yaw_worst, 0.5);
    EXPECT_LT(lever_worst, 10.0);
    if (eights > 1) { EXPECT_EQ(found, 44); }
  }
}

}  // namespace
}  // namespace nacelle::calibration
