// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/twist_limiter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reference_limiter.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr double kCycle_s = 0.02;

TwistLimits both(const AxisLimits& linear, const AxisLimits& angular) {
  return {resolved(linear).value(), resolved(angular).value()};
}
AxisLimits axis(double velocity, double acceleration, double deceleration = AxisLimits::kOff,
                double jerk = AxisLimits::kOff) {
  AxisLimits limits;
  limits.max_velocity = velocity;
  limits.max_acceleration = acceleration;
  limits.max_deceleration = deceleration;
  limits.max_jerk = jerk;
  return limits;
}
// v w' - w v': zero when two twists are on one curve.
double off_curve(const BodyTwist& a, const BodyTwist& b) {
  return a.linear_mps * b.angular_rps - a.angular_rps * b.linear_mps;
}
double any(std::mt19937& random, double size) { return std::uniform_real_distribution<double>{-size, size}(random); }
AxisLimits random_axis(std::mt19937& random) {
  const auto positive = [&] { return std::abs(any(random, 2.0)) + 0.05; };
  return axis(positive(), positive(), random() % 2 == 0 ? AxisLimits::kOff : -positive(),
              random() % 3 == 0 ? 20 * positive() : AxisLimits::kOff);
}

TEST(TwistLimiter, keeps_the_wanted_curve_from_rest_until_it_is_reached) {
  const unsigned seed = 31;
  std::mt19937 random{seed};
  for (int drive = 0; drive < 100; ++drive) {
    TwistLimiter limiter{both(random_axis(random), random_axis(random))};
    const BodyTwist wanted{any(random, 3.0), any(random, 3.0)};
    double speed = 0.0;
    for (int cycle = 0; cycle < 2000; ++cycle) {
      const BodyTwist next = limiter.limit(wanted, kCycle_s);
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", drive " << drive << ", cycle " << cycle);
      ASSERT_NEAR(off_curve(next, wanted), 0.0, 1e-12);
      ASSERT_GE(std::hypot(next.linear_mps, next.angular_rps), speed - 1e-12) << "never slower on the way up";
      speed = std::hypot(next.linear_mps, next.angular_rps);
    }
    ASSERT_GT(speed, 0.0);
  }
}

TEST(TwistLimiter, keeps_the_old_curve_while_it_brakes_to_a_stop) {
  const unsigned seed = 32;
  std::mt19937 random{seed};
  for (int drive = 0; drive < 100; ++drive) {
    TwistLimiter limiter{both(random_axis(random), random_axis(random))};
    const BodyTwist wanted{any(random, 3.0), any(random, 3.0)};
    for (int cycle = 0; cycle < 3000; ++cycle) limiter.limit(wanted, kCycle_s);
    const BodyTwist before = limiter.last();
    for (int cycle = 0; cycle < 3000; ++cycle) {
      const BodyTwist next = limiter.limit({}, kCycle_s);
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", drive " << drive << ", cycle " << cycle);
      ASSERT_NEAR(off_curve(next, before), 0.0, 1e-12);
    }
    EXPECT_EQ(limiter.last(), BodyTwist{}) << "drive " << drive;
  }
}

TEST(TwistLimiter, never_breaks_a_limit_and_always_arrives) {
  const unsigned seed = 33;
  std::mt19937 random{seed};
  for (int drive = 0; drive < 100; ++drive) {
    const TwistLimits limits = both(random_axis(random), random_axis(random));
    TwistLimiter limiter{limits};
    AxisMemory linear, angular;
    for (int leg = 0; leg < 6; ++leg) {
      const BodyTwist wanted = random() % 4 == 0 ? BodyTwist{} : BodyTwist{any(random, 3.0), any(random, 3.0)};
      const int cycles = leg == 5 ? 6000 : 1 + static_cast<int>(random() % 60);
      BodyTwist next;
      for (int cycle = 0; cycle < cycles; ++cycle) {
        const auto of_linear = allowed_change(limits.linear, linear, kCycle_s);
        const auto of_angular = allowed_change(limits.angular, angular, kCycle_s);
        next = limiter.limit(wanted, kCycle_s);
        SCOPED_TRACE(::testing::Message()
                     << "seed " << seed << ", drive " << drive << ", leg " << leg << ", cycle " << cycle);
        ASSERT_GE(next.linear_mps - linear.last, of_linear.lowest - 1e-9);
        ASSERT_LE(next.linear_mps - linear.last, of_linear.highest + 1e-9);
        ASSERT_GE(next.angular_rps - angular.last, of_angular.lowest - 1e-9);
        ASSERT_LE(next.angular_rps - angular.last, of_angular.highest + 1e-9);
        linear = {next.linear_mps, linear.last};
        angular = {next.angular_rps, angular.last};
      }
      if (leg < 5) continue;
      // Arrived: on the wanted curve, and as fast as the velocity limits let it be there.
      const double ratio = std::min({1.0, limits.linear.max_velocity / std::abs(wanted.linear_mps),
                                     limits.angular.max_velocity / std::abs(wanted.angular_rps)});
      EXPECT_NEAR(next.linear_mps, wanted.linear_mps * ratio, 1e-9) << "seed " << seed << ", drive " << drive;
      EXPECT_NEAR(next.angular_rps, wanted.angular_rps * ratio, 1e-9) << "seed " << seed << ", drive " << drive;
    }
  }
}

TEST(TwistLimiter, is_the_single_axis_limiter_when_only_one_axis_moves) {
  const unsigned seed = 34;
  std::mt19937 random{seed};
  for (int drive = 0; drive < 100; ++drive) {
    const AxisLimits given = random_axis(random);
    const bool turns = drive % 2 == 0;
    TwistLimiter limiter{turns ? both({}, given) : both(given, random_axis(random))};
    const ReferenceLimiter reference{given};
    double last = 0.0, before_last = 0.0, wanted = 0.0;
    for (int cycle = 0; cycle < 400; ++cycle) {
      if (cycle % 25 == 0) wanted = random() % 4 == 0 ? 0.0 : any(random, 4.0);
      const BodyTwist next = limiter.limit(turns ? BodyTwist{0.0, wanted} : BodyTwist{wanted, 0.0}, kCycle_s);
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", drive " << drive << ", cycle " << cycle);
      const double expected = reference.limit(wanted, last, before_last, kCycle_s);
      ASSERT_NEAR(turns ? next.angular_rps : next.linear_mps, expected, 1e-9);
      ASSERT_EQ(turns ? next.linear_mps : next.angular_rps, 0.0);
      before_last = last;
      last = expected;
    }
  }
}

TEST(TwistLimiter, scales_the_other_axis_by_the_ratio_of_the_limited_one) {
  TwistLimiter limiter{both(axis(0.5, AxisLimits::kOff), {})};
  const BodyTwist next = limiter.limit({1.0, 0.8}, kCycle_s);
  EXPECT_DOUBLE_EQ(next.linear_mps, 0.5);
  EXPECT_DOUBLE_EQ(next.angular_rps, 0.4);
}

TEST(TwistLimiter, takes_the_smaller_ratio_when_both_axes_are_limited) {
  TwistLimiter limiter{both(axis(0.5, AxisLimits::kOff), axis(0.2, AxisLimits::kOff))};
  const BodyTwist next = limiter.limit({1.0, 0.8}, kCycle_s);  // ratios 0.5 and 0.25
  EXPECT_DOUBLE_EQ(next.linear_mps, 0.25);
  EXPECT_DOUBLE_EQ(next.angular_rps, 0.2);
}

TEST(TwistLimiter, passes_along_the_straight_line_when_the_curve_changes_at_speed) {
  TwistLimiter limiter{both(axis(1.0, 1.0, -1.0), axis(2.0, 2.0))};
  for (int i = 0; i < 100; ++i) limiter.limit({0.3, 0.0}, kCycle_s);
  const BodyTwist next = limiter.limit({0.3, 1.0}, kCycle_s);  // no twist with w/v = 1/0.3 is in reach
  EXPECT_DOUBLE_EQ(next.linear_mps, 0.3);
  EXPECT_NEAR(next.angular_rps, 0.04, 1e-12);
}

TEST(TwistLimiter, brakes_with_the_deceleration_and_speeds_up_with_the_acceleration) {
  TwistLimiter limiter{both(axis(1.0, 0.5, -2.0), {})};
  EXPECT_NEAR(limiter.limit({1.0, 0.0}, kCycle_s).linear_mps, 0.01, 1e-12);
  for (int i = 0; i < 200; ++i) limiter.limit({1.0, 0.0}, kCycle_s);
  EXPECT_NEAR(limiter.limit({}, kCycle_s).linear_mps, 1.0 - 2.0 * kCycle_s, 1e-12);
}

TEST(TwistLimiter, starts_from_rest_after_a_reset) {
  TwistLimiter limiter{both(axis(1.0, 0.5), {})};
  for (int i = 0; i < 200; ++i) limiter.limit({1.0, 0.0}, kCycle_s);
  limiter.reset();
  EXPECT_EQ(limiter.last(), BodyTwist{});
  EXPECT_NEAR(limiter.limit({1.0, 0.0}, kCycle_s).linear_mps, 0.01, 1e-12);
}

}  // namespace
}  // namespace nacelle::diff_drive
