// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/drive_kinematics.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace nacelle::diff_drive {
namespace {

TEST(DriveKinematics, wheel_rates_and_body_twist_undo_each_other) {
  const unsigned seed = 11;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> length{0.01, 1.0};
  std::uniform_real_distribution<double> speed{-3.0, 3.0};
  for (int i = 0; i < 500; ++i) {
    const DriveGeometry drive{length(random), length(random), length(random)};
    const BodyTwist twist{speed(random), speed(random)};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << i);

    const BodyTwist back = body_twist(drive, wheel_rates(drive, twist));

    EXPECT_NEAR(back.linear_mps, twist.linear_mps, 1e-12);
    EXPECT_NEAR(back.angular_rps, twist.angular_rps, 1e-11);
  }
}

TEST(DriveKinematics, follows_the_controllers_formula) {
  // left = (v - w L/2)/r_left, right = (v + w L/2)/r_right
  const WheelRates wheels = wheel_rates({0.4, 0.05, 0.04}, {0.3, 0.5});
  EXPECT_DOUBLE_EQ(wheels.left_rps, (0.3 - 0.5 * 0.2) / 0.05);
  EXPECT_DOUBLE_EQ(wheels.right_rps, (0.3 + 0.5 * 0.2) / 0.04);
}

TEST(DriveKinematics, turning_left_in_place_drives_the_wheels_against_each_other) {
  const WheelRates wheels = wheel_rates({}, {0.0, 1.0});
  EXPECT_LT(wheels.left_rps, 0.0);
  EXPECT_DOUBLE_EQ(wheels.left_rps, -wheels.right_rps);
}

TEST(DriveKinematics, a_wheel_limit_keeps_the_curve) {
  const DriveGeometry drive;
  const unsigned seed = 12;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> speed{-3.0, 3.0};
  for (int i = 0; i < 500; ++i) {
    const BodyTwist wanted{speed(random), speed(random)};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << i);

    const BodyTwist twist = within_wheel_rate(drive, wanted, 20.0);

    const WheelRates wheels = wheel_rates(drive, twist);
    EXPECT_LE(std::abs(wheels.left_rps), 20.0 + 1e-9);
    EXPECT_LE(std::abs(wheels.right_rps), 20.0 + 1e-9);
    EXPECT_NEAR(twist.linear_mps * wanted.angular_rps, twist.angular_rps * wanted.linear_mps, 1e-12);
  }
}

TEST(DriveKinematics, an_infinite_wheel_limit_changes_nothing) {
  EXPECT_EQ(within_wheel_rate({}, {2.0, -4.0}, std::numeric_limits<double>::infinity()), (BodyTwist{2.0, -4.0}));
}

}  // namespace
}  // namespace nacelle::diff_drive
