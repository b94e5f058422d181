// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/axis_limits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "reference_limiter.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr double kOff = AxisLimits::kOff;

// Random limits of which some are off.
AxisLimits random_limits(std::mt19937& random) {
  std::uniform_real_distribution<double> size{0.1, 2.0};
  const auto maybe = [&](double sign) { return random() % 3 == 0 ? kOff : sign * size(random); };
  AxisLimits limits;
  limits.max_velocity = maybe(1);
  limits.min_velocity = maybe(-1);
  limits.max_acceleration = maybe(1);
  limits.max_deceleration = maybe(-1);
  limits.max_acceleration_reverse = maybe(-1);
  limits.max_deceleration_reverse = maybe(1);
  limits.max_jerk = random() % 2 == 0 ? kOff : 20 * size(random);
  limits.min_jerk = random() % 2 == 0 ? kOff : -20 * size(random);
  // A lower limit without its upper one is off as a whole; keep the reference simple.
  return limits;
}

TEST(AxisLimits, agree_with_an_independent_limiter_over_random_drives) {
  const unsigned seed = 2026;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> any{-4.0, 4.0};
  for (int drive = 0; drive < 100; ++drive) {
    const AxisLimits given = random_limits(random);
    const AxisLimits limits = resolved(given).value();
    const ReferenceLimiter reference{given};
    AxisMemory memory;
    double wanted = 0.0;
    for (int cycle = 0; cycle < 200; ++cycle) {
      if (cycle % 20 == 0) wanted = random() % 4 == 0 ? 0.0 : any(random);
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", drive " << drive << ", cycle " << cycle);

      const double speed = limited_speed(limits, memory, wanted, 0.02);

      ASSERT_NEAR(speed, reference.limit(wanted, memory.last, memory.before_last, 0.02), 1e-12);
      const SpeedChangeRange range = allowed_change(limits, memory, 0.02);
      ASSERT_LE(range.lowest, 0.0);
      ASSERT_GE(range.highest, 0.0);
      ASSERT_GE(speed - memory.last, range.lowest - 1e-12);
      ASSERT_LE(speed - memory.last, range.highest + 1e-12);
      memory = {speed, memory.last};
    }
  }
}

TEST(AxisLimits, every_change_in_the_allowed_range_passes_unchanged) {
  const unsigned seed = 2027;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> share{0.0, 1.0};
  for (int i = 0; i < 2000; ++i) {
    const AxisLimits limits = resolved(random_limits(random)).value();
    AxisMemory memory;
    for (int cycle = 0; cycle < 5; ++cycle)
      memory = {limited_speed(limits, memory, 4.0 * share(random) - 2.0, 0.02), memory.last};
    const SpeedChangeRange range = allowed_change(limits, memory, 0.02);
    if (std::isinf(range.lowest) || std::isinf(range.highest)) continue;
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << i);

    const double speed = memory.last + range.lowest + share(random) * (range.highest - range.lowest);

    EXPECT_NEAR(limited_speed(limits, memory, speed, 0.02), speed, 1e-12);
  }
}

TEST(AxisLimits, all_off_is_the_default_and_changes_nothing) {
  const AxisLimits limits = resolved({}).value();
  EXPECT_EQ(limited_speed(limits, {0.0, 0.0}, 12.5, 0.02), 12.5);
  EXPECT_EQ(limited_speed(limits, {1.0, -1.0}, -12.5, 0.02), -12.5);
}

struct Fill {
  const char* what;
  AxisLimits given;
  double AxisLimits::*field;
  double becomes;
};
TEST(AxisLimits, fill_in_what_nan_stands_for) {
  AxisLimits chain;
  chain.max_velocity = 2.0;
  chain.max_acceleration = 1.5;
  chain.max_jerk = 9.0;
  AxisLimits reverse = chain;
  reverse.max_acceleration_reverse = -0.7;
  AxisLimits braking = chain;
  braking.max_deceleration = -3.0;
  const Fill table[] = {
      {"min_velocity is -max_velocity", chain, &AxisLimits::min_velocity, -2.0},
      {"max_acceleration_reverse is -max_acceleration", chain, &AxisLimits::max_acceleration_reverse, -1.5},
      {"max_deceleration is max_acceleration_reverse", chain, &AxisLimits::max_deceleration, -1.5},
      {"max_deceleration is the given max_acceleration_reverse", reverse, &AxisLimits::max_deceleration, -0.7},
      {"max_deceleration_reverse is -max_deceleration", chain, &AxisLimits::max_deceleration_reverse, 1.5},
      {"max_deceleration_reverse is the given braking", braking, &AxisLimits::max_deceleration_reverse, 3.0},
      {"min_jerk is -max_jerk", chain, &AxisLimits::min_jerk, -9.0},
  };
  for (const Fill& row : table) { EXPECT_DOUBLE_EQ(resolved(row.given).value().*row.field, row.becomes) << row.what; }
}

TEST(AxisLimits, refuse_wrong_signs_and_name_the_field) {
  struct Row {
    double AxisLimits::*field;
    double value;
    const char* name;
  };
  const double infinite = std::numeric_limits<double>::infinity();
  const Row table[] = {
      {&AxisLimits::max_velocity, -0.1, "max_velocity"},
      {&AxisLimits::min_velocity, 0.1, "min_velocity"},
      {&AxisLimits::max_acceleration, -1, "max_acceleration"},
      {&AxisLimits::max_deceleration, 1.5, "max_deceleration"},
      {&AxisLimits::max_acceleration_reverse, 1, "max_acceleration_reverse"},
      {&AxisLimits::max_deceleration_reverse, -1, "max_deceleration_reverse"},
      {&AxisLimits::max_jerk, -1, "max_jerk"},
      {&AxisLimits::min_jerk, 1, "min_jerk"},
      {&AxisLimits::max_velocity, infinite, "max_velocity"},
      {&AxisLimits::min_jerk, -infinite, "min_jerk"},
  };
  for (const Row& row : table) {
    AxisLimits limits;
    limits.*row.field = row.value;
    const auto result = resolved(limits);
    ASSERT_FALSE(result.has_value()) << row.name;
    EXPECT_EQ(result.error().name, row.name);
    EXPECT_EQ(result.error().value, row.value);
  }
}

TEST(AxisLimits, use_the_variant_that_belongs_to_the_present_direction) {
  AxisLimits given;
  given.max_acceleration = 1.0;
  given.max_deceleration = -2.0;
  given.max_acceleration_reverse = -3.0;
  given.max_deceleration_reverse = 4.0;
  const AxisLimits limits = resolved(given).value();
  const double dt = 0.1;
  EXPECT_NEAR(limited_speed(limits, {1.0, 1.0}, 9.0, dt), 1.1, 1e-12);      // speeding up forward
  EXPECT_NEAR(limited_speed(limits, {1.0, 1.0}, -9.0, dt), 0.8, 1e-12);     // braking forward
  EXPECT_NEAR(limited_speed(limits, {-1.0, -1.0}, -9.0, dt), -1.3, 1e-12);  // speeding up backwards
  EXPECT_NEAR(limited_speed(limits, {-1.0, -1.0}, 9.0, dt), -0.6, 1e-12);   // braking backwards
  EXPECT_NEAR(limited_speed(limits, {0.0, 0.0}, 9.0, dt), 0.1, 1e-12);      // from rest
  EXPECT_NEAR(limited_speed(limits, {0.0, 0.0}, -9.0, dt), -0.3, 1e-12);
}

}  // namespace
}  // namespace nacelle::diff_drive
