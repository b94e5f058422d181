// SPDX-License-Identifier: Apache-2.0
#include "imu/model/gyro_calibration.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle::imu {
namespace {

TEST(GyroCalibration, finds_the_bias_under_the_noise) {
  const unsigned seed = 3;
  std::mt19937 random{seed};
  std::normal_distribution<double> noise{0.0, 0.0017};  // 0.1 deg/s
  GyroCalibration calibration{400, 0.01, 0.05};
  for (int i = 0; i < 400; ++i) calibration.add({0.002 + noise(random), -0.001 + noise(random), 0.004 + noise(random)});
  const auto bias = calibration.result();
  ASSERT_TRUE(bias);
  // Five standard deviations of a mean of 400.
  EXPECT_NEAR(bias->mean_rps[0], 0.002, 5 * 0.0017 / 20) << "seed " << seed;
  EXPECT_NEAR(bias->mean_rps[1], -0.001, 5 * 0.0017 / 20);
  EXPECT_NEAR(bias->mean_rps[2], 0.004, 5 * 0.0017 / 20);
  EXPECT_NEAR(bias->stddev_rps, 0.0017, 0.0003);
}

TEST(GyroCalibration, needs_all_its_samples) {
  GyroCalibration calibration{3, 0.01, 0.05};
  calibration.add({});
  calibration.add({});
  EXPECT_EQ(calibration.result().error(), CalibrationFault::TooFewSamples);
  calibration.add({});
  EXPECT_TRUE(calibration.result());
}

TEST(GyroCalibration, refuses_a_robot_that_moves) {
  GyroCalibration calibration{10, 0.01, 0.5};
  for (int i = 0; i < 10; ++i) calibration.add({0.0, 0.0, i * 0.02});
  EXPECT_EQ(calibration.result().error(), CalibrationFault::Moving);
}

TEST(GyroCalibration, refuses_a_robot_that_turns_evenly) {
  GyroCalibration calibration{10, 0.01, 0.05};
  for (int i = 0; i < 10; ++i) calibration.add({0.0, 0.0, 0.3});
  EXPECT_EQ(calibration.result().error(), CalibrationFault::Turning);
}

TEST(GyroCalibration, begins_anew_after_a_restart) {
  GyroCalibration calibration{2, 0.01, 0.05};
  calibration.add({1.0, 0.0, 0.0});
  calibration.restart();
  calibration.add({0.01, 0.0, 0.0});
  calibration.add({0.01, 0.0, 0.0});
  ASSERT_TRUE(calibration.result());
  EXPECT_NEAR(calibration.result()->mean_rps[0], 0.01, 1e-12);
}

}  // namespace
}  // namespace nacelle::imu
