// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/yaw_integral.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nacelle::calibration {
namespace {

constexpr double kHalfTurn_rad = std::numbers::pi;

/// A turn by 4 pi that begins and ends at rest, in 10 s: its rate at t.
double rate(double t) { return 4.0 * kHalfTurn_rad / 10.0 * (1.0 - std::cos(2.0 * kHalfTurn_rad * t / 10.0)); }

TEST(YawIntegral, counts_turns_and_takes_the_bias_off) {
  YawIntegral yaw{-0.02};
  for (int i = 0; i <= 1000; ++i) yaw.take(1.7e9 + 0.01 * i, rate(0.01 * i) - 0.02);
  EXPECT_NEAR(yaw.yaw_rad(), 4.0 * kHalfTurn_rad, 1e-4);
  EXPECT_TRUE(yaw.is_whole());
}

TEST(YawIntegral, lost_readings_cost_little_until_they_are_too_many) {
  YawIntegral sparse{0.0}, holed{0.0};
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.01 * i;
    if (i < 200 || i > 245) sparse.take(t, rate(t));
    if (i < 200 || i > 255) holed.take(t, rate(t));
  }
  EXPECT_NEAR(sparse.yaw_rad(), 4.0 * kHalfTurn_rad, 0.01);
  EXPECT_TRUE(sparse.is_whole());
  EXPECT_FALSE(holed.is_whole());
  EXPECT_NEAR(holed.longest_gap_s(), 0.57, 1e-9);
}

TEST(YawIntegral, is_no_measurement_without_readings_or_when_the_clock_went_back) {
  YawIntegral yaw{0.0};
  EXPECT_FALSE(yaw.is_whole());
  yaw.take(10.0, 1.0);
  EXPECT_FALSE(yaw.is_whole());
  yaw.take(10.01, 1.0);
  EXPECT_TRUE(yaw.is_whole());
  yaw.take(9.0, 1.0);
  EXPECT_FALSE(yaw.is_whole());
  EXPECT_NEAR(yaw.yaw_rad(), 0.01, 1e-9);
}

}  // namespace
}  // namespace nacelle::calibration
