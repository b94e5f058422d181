// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/lever_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "driven_imu.hpp"

namespace nacelle::calibration {
namespace {

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

}  // namespace
}  // namespace nacelle::calibration
