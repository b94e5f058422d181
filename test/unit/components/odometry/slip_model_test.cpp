// SPDX-License-Identifier: Apache-2.0
#include "odometry/model/slip_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace nacelle::odometry {
namespace {

constexpr double kTrack_m = 0.3;

TEST(SlipModel, has_the_stddev_that_its_parameters_name) {
  const SlipModel slip{.distance_m = 0.05, .lateral_m = 0.02, .heading_rad = 0.01, .turn_rad = 0.03};
  const StepVariance ahead = variance_of({4.0, 4.0}, kTrack_m, slip);
  EXPECT_NEAR(std::sqrt(ahead.along), 0.05 * 2.0, 1e-12) << "4 m, whose root is 2";
  EXPECT_NEAR(std::sqrt(ahead.across), 0.02 * 2.0, 1e-12);
  EXPECT_NEAR(std::sqrt(ahead.turn), 0.01 * 2.0, 1e-12);
  const StepVariance about = variance_of({-0.15, 0.15}, kTrack_m, slip);  // a radian on the spot
  EXPECT_NEAR(about.turn, 0.03 * 0.03 + 0.01 * 0.01 * 0.15, 1e-12);
  EXPECT_EQ(variance_of({0.0, 0.0}, kTrack_m, slip).along, 0.0);
}

TEST(SlipModel, does_not_depend_on_the_length_of_a_step) {
  const SlipModel slip;
  PlanarPose once, often;
  once = integrate_with_slip(once, {2.0, 2.0}, kTrack_m, slip);
  for (int i = 0; i < 1000; ++i) often = integrate_with_slip(often, {0.002, 0.002}, kTrack_m, slip);
  EXPECT_NEAR(often.covariance(0, 0), once.covariance(0, 0), 1e-12);
  EXPECT_NEAR(often.covariance(2, 2), once.covariance(2, 2), 1e-12);
  // What the heading does to the position grows on the way; one step knows only the middle of it.
  EXPECT_NEAR(often.covariance(1, 1),
              slip.lateral_m * slip.lateral_m * 2.0 + slip.heading_rad * slip.heading_rad * 8.0 / 3.0, 1e-4);
}

TEST(SlipModel, forwards_and_backwards_are_as_unsure) {
  const SlipModel slip;
  const PlanarPose ahead = integrate_with_slip({}, {1.0, 0.7}, kTrack_m, slip),
                   back = integrate_with_slip({}, {-1.0, -0.7}, kTrack_m, slip);
  EXPECT_NEAR(ahead.covariance.trace(), back.covariance.trace(), 1e-12);
}

// The covariance is honest: errors drawn from the model have a normalised square (NEES) of one per degree of freedom.
TEST(SlipModel, holds_the_errors_of_a_thousand_simulated_drives) {
  const unsigned seed = 75;
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  const SlipModel slip;
  double nees = 0.0;
  constexpr int kDrives = 1000;
  for (int drive = 0; drive < kDrives; ++drive) {
    PlanarPose told, real;
    for (int i = 0; i < 400; ++i) {
      const bool turning = i % 100 >= 80;
      const double turn_step = M_PI / 2 / 20 * kTrack_m / 2;
      const WheelStep step = turning ? WheelStep{-turn_step, turn_step} : WheelStep{0.0125, 0.0125};
      told = integrate_with_slip(told, step, kTrack_m, slip);
      const StepVariance v = variance_of(step, kTrack_m, slip);
      const double along = std::sqrt(v.along) * normal(random);
      const double half = 0.5 * kTrack_m * std::sqrt(v.turn) * normal(random);
      const double across = std::sqrt(v.across) * normal(random);
      const Moved to =
          move(real.x_m, real.y_m, real.yaw_rad, {step.left_m + along - half, step.right_m + along + half}, kTrack_m);
      real.x_m = to.x_m - across * std::sin(to.yaw_rad);
      real.y_m = to.y_m + across * std::cos(to.yaw_rad);
      real.yaw_rad = to.yaw_rad;
    }
    const Eigen::Vector3d error{real.x_m - told.x_m, real.y_m - told.y_m, real.yaw_rad - told.yaw_rad};
    nees += error.dot(told.covariance.inverse() * error) / 3.0 / kDrives;
  }
  EXPECT_GT(nees, 0.85) << "seed " << seed;
  EXPECT_LT(nees, 1.15) << "seed " << seed;
}

TEST(SlipModel, of_single_wheels_is_the_same_as_before) {
  const StepNoise noise{.k_left_m = 2e-5, .k_right_m = 8e-5, .k_turn_rad = 3e-4};
  const StepVariance v = variance_of({1.0, 2.0}, kTrack_m, noise);
  EXPECT_DOUBLE_EQ(v.along, 0.25 * (2e-5 + 16e-5));
  EXPECT_DOUBLE_EQ(v.turn, (2e-5 + 16e-5) / 0.09 + 3e-4 / kTrack_m);
  EXPECT_DOUBLE_EQ(v.along_turn, 0.5 * (16e-5 - 2e-5) / kTrack_m);
}

}  // namespace
}  // namespace nacelle::odometry
