// SPDX-License-Identifier: Apache-2.0
#include "calibration_commands/model/base_fit.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <optional>

namespace nacelle::calibration {
namespace {

constexpr double kPi = std::numbers::pi;

BaseGeometry believed() {
  BaseGeometry base;
  base.wheel_radius_m = 0.033;
  base.wheel_separation_m = 0.30;
  base.left_radius_multiplier = 1.05;
  base.right_radius_multiplier = 1.06;
  base.separation_multiplier = 0.9;
  return base;
}

/// What the wheels of the real base turn on a way of d m and w rad.
WheelTurn turn_of(double left_radius_m, double right_radius_m, double separation_m, double d, double w) {
  return {(d - w * separation_m / 2.0) / left_radius_m, (d + w * separation_m / 2.0) / right_radius_m};
}

template <typename T>
std::optional<BaseFault> fault_of(const Result<T, BaseFault>& result) {
  return result ? std::optional<BaseFault>{} : result.error();
}

TEST(BaseFit, the_wheels_give_way_and_turn) {
  BaseGeometry base;
  base.wheel_radius_m = 0.05;
  base.wheel_separation_m = 0.4;
  const WheelTurn turn = turn_of(0.05, 0.05, 0.4, 1.5, 0.7);
  EXPECT_NEAR(distance_m(base, turn), 1.5, 1e-12);
  EXPECT_NEAR(yaw_rad(base, turn), 0.7, 1e-12);
}

TEST(BaseFit, a_line_and_a_turn_find_the_real_base_from_any_start) {
  // The ratio of the wheels is right, as a line cannot show it; all else is wrong.
  const double scale = 0.93, separation_m = 0.312;
  const BaseGeometry wrong = believed();
  const double left = wrong.left_radius_m() * scale, right = wrong.right_radius_m() * scale;
  const auto straight = with_measured_distance(wrong, turn_of(left, right, separation_m, 1.987, 0.0), 1.987);
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->left_radius_m(), left, 1e-12);
  EXPECT_NEAR(straight->right_radius_m(), right, 1e-12);
  const auto both = with_measured_yaw(*straight, turn_of(left, right, separation_m, 0.0, 3.9 * kPi), 3.9 * kPi);
  ASSERT_TRUE(both);
  EXPECT_NEAR(both->separation_m(), separation_m, 1e-12);
  EXPECT_EQ(both->wheel_radius_m, wrong.wheel_radius_m) << "the board has the same";
  EXPECT_EQ(both->wheel_separation_m, wrong.wheel_separation_m);
}

TEST(BaseFit, a_right_base_stays_as_it_is) {
  const BaseGeometry base = believed();
  const auto turn = [&](double d, double w) {
    return turn_of(base.left_radius_m(), base.right_radius_m(), base.separation_m(), d, w);
  };
  const auto straight = with_measured_distance(base, turn(2.0, 0.0), 2.0);
  ASSERT_TRUE(straight);
  EXPECT_NEAR(straight->left_radius_multiplier, base.left_radius_multiplier, 1e-12);
  const auto both = with_measured_yaw(base, turn(0.0, 4.0 * kPi), 4.0 * kPi);
  ASSERT_TRUE(both);
  EXPECT_NEAR(both->separation_multiplier, base.separation_multiplier, 1e-12);
}

TEST(BaseFit, refuses_what_is_no_straight_line) {
  const BaseGeometry base = believed();
  const auto turn = [&](double d, double w) {
    return turn_of(base.left_radius_m(), base.right_radius_m(), base.separation_m(), d, w);
  };
  EXPECT_EQ(fault_of(with_measured_distance(base, turn(0.0, 0.0), 2.0)), BaseFault::NoMotion);
  EXPECT_EQ(fault_of(with_measured_distance(base, turn(-2.0, 0.0), 2.0)), BaseFault::NoMotion);
  EXPECT_EQ(fault_of(with_measured_distance(base, turn(2.0, 0.0), 0.0)), BaseFault::NoMotion);
  EXPECT_EQ(fault_of(with_measured_distance(base, turn(2.0, 0.3), 2.0)), BaseFault::NotStraight);
  EXPECT_EQ(fault_of(with_measured_distance(base, turn(2.0, 0.0), 200.0)), BaseFault::Absurd) << "centimetres";
  EXPECT_EQ(fault_of(with_measured_distance(base, turn(2.0, 0.0), 0.9)), BaseFault::Absurd);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(fault_of(with_measured_distance(base, turn(2.0, 0.0), nan)));
  EXPECT_TRUE(fault_of(with_measured_distance(base, WheelTurn{nan, 1.0}, 2.0)));
}

TEST(BaseFit, refuses_what_is_no_turn_on_the_spot) {
  const BaseGeometry base = believed();
  const auto turn = [&](double d, double w) {
    return turn_of(base.left_radius_m(), base.right_radius_m(), base.separation_m(), d, w);
  };
  EXPECT_EQ(fault_of(with_measured_yaw(base, turn(0.0, 0.1), 0.1)), BaseFault::NoMotion);
  EXPECT_EQ(fault_of(with_measured_yaw(base, turn(0.0, -6.0), 6.0)), BaseFault::NoMotion);
  EXPECT_EQ(fault_of(with_measured_yaw(base, turn(0.5, 6.0), 6.0)), BaseFault::NotOnTheSpot);
  EXPECT_EQ(fault_of(with_measured_yaw(base, turn(0.0, 6.0), 2.0)), BaseFault::Absurd) << "turns, not radians";
}

}  // namespace
}  // namespace nacelle::calibration
