// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/wheel_pid.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "simulated_motor.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr double kPeriod = 0.02;

WheelPidSettings usual() { return {.feed_forward = 0.05, .p = 0.04, .i = 0.4}; }

/// A motor under control, in told time.
struct Drive {
  explicit Drive(const WheelPidSettings& settings) : pid(settings) {}
  double cycle(double wanted_rps, double period_s = kPeriod) {
    output = pid.update(wanted_rps, motor.speed_rps, period_s);
    motor.run(beyond_dead_band(output, dead_band, 1.0), period_s);
    return motor.speed_rps;
  }
  void run(double wanted_rps, double seconds) {
    for (double t = 0; t < seconds; t += kPeriod) cycle(wanted_rps);
  }

  WheelPid pid;
  SimulatedMotor motor;
  double dead_band = 0.0;
  double output = 0.0;
};

TEST(WheelPid, each_term_is_what_the_formula_says) {
  WheelPid feed_forward{{.feed_forward = 0.1}};
  EXPECT_DOUBLE_EQ(feed_forward.update(3.0, 99.0, kPeriod), 0.3);
  WheelPid p{{.p = 0.1}};
  EXPECT_DOUBLE_EQ(p.update(3.0, 1.0, kPeriod), 0.2);
  EXPECT_DOUBLE_EQ(p.update(1.0, 3.0, kPeriod), -0.2);
  WheelPid i{{.i = 0.5}};
  EXPECT_DOUBLE_EQ(i.update(1.0, 0.0, kPeriod), 0.0) << "no time has passed before the first update";
  EXPECT_DOUBLE_EQ(i.update(1.0, 0.0, kPeriod), 0.01);
  EXPECT_DOUBLE_EQ(i.update(1.0, 0.0, 0.04), 0.03);
  WheelPid d{{.d = 0.01, .filter_s = 0.0}};
  EXPECT_DOUBLE_EQ(d.update(0.0, 1.0, kPeriod), 0.0);
  EXPECT_DOUBLE_EQ(d.update(0.0, 2.0, kPeriod), -0.01 * 50.0);
}

TEST(WheelPid, the_derivative_is_filtered_and_ignores_steps_of_the_wanted_speed) {
  WheelPid pid{{.d = 0.01, .filter_s = 0.06}};
  static_cast<void>(pid.update(0.0, 0.0, kPeriod));
  EXPECT_NEAR(pid.update(0.0, 1.0, kPeriod), -0.01 * 50.0 * 0.25, 1e-12);
  EXPECT_NEAR(pid.update(0.0, 1.0, kPeriod), -0.01 * 50.0 * 0.25 * 0.75, 1e-12);
  pid.reset();
  static_cast<void>(pid.update(0.0, 1.0, kPeriod));
  EXPECT_DOUBLE_EQ(pid.update(10.0, 1.0, kPeriod), 0.0);
}

TEST(WheelPid, settles_on_the_wanted_speed) {
  for (const double dead_band : {0.0, 0.25}) {
    Drive drive{usual()};
    drive.motor.dead_band = dead_band;  // which this controller is not told of
    double highest_rps = 0.0;
    for (int cycle = 0; cycle < 100; ++cycle) highest_rps = std::max(highest_rps, drive.cycle(8.0));
    EXPECT_NEAR(drive.motor.speed_rps, 8.0, 0.05) << dead_band;
    EXPECT_LT(highest_rps, 8.0 * 1.15) << dead_band;
    drive.run(-8.0, 2.0);
    EXPECT_NEAR(drive.motor.speed_rps, -8.0, 0.05) << dead_band;
  }
}

TEST(WheelPid, a_dead_band_that_is_known_makes_slow_speeds_as_quick_as_fast_ones) {
  const auto slowness = [](double known) {
    Drive drive{usual()};
    drive.motor.dead_band = 0.25;
    drive.dead_band = known;
    double missed_rad = 0.0;
    for (int cycle = 0; cycle < 100; ++cycle) missed_rad += std::abs(1.0 - drive.cycle(1.0)) * kPeriod;
    return missed_rad;
  };
  EXPECT_LT(slowness(0.25), 0.4 * slowness(0.0));
}

TEST(WheelPid, a_wheel_that_was_blocked_for_a_minute_starts_like_one_that_was_blocked_for_a_second) {
  const auto overshoot_after = [](double seconds) {
    Drive drive{usual()};
    drive.motor.is_blocked = true;
    drive.run(8.0, seconds);
    EXPECT_DOUBLE_EQ(drive.output, 1.0);
    EXPECT_LE(drive.pid.integral(), 1.0);
    drive.motor.is_blocked = false;
    double highest_rps = 0.0;
    for (int cycle = 0; cycle < 150; ++cycle) highest_rps = std::max(highest_rps, drive.cycle(8.0));
    EXPECT_NEAR(drive.motor.speed_rps, 8.0, 0.1);
    return highest_rps;
  };
  EXPECT_NEAR(overshoot_after(60.0), overshoot_after(1.0), 0.01);
}

TEST(WheelPid, a_speed_out_of_reach_winds_nothing_up) {
  Drive drive{usual()};
  drive.run(40.0, 20.0);  // twice what the motor can do
  EXPECT_DOUBLE_EQ(drive.output, 1.0);
  drive.run(8.0, 1.0);
  EXPECT_NEAR(drive.motor.speed_rps, 8.0, 0.3);
}

TEST(WheelPid, the_output_limit_holds_both_ways) {
  WheelPid pid{{.p = 1.0, .output_limit = 0.6}};
  EXPECT_DOUBLE_EQ(pid.update(9.0, 0.0, kPeriod), 0.6);
  EXPECT_DOUBLE_EQ(pid.update(-9.0, 0.0, kPeriod), -0.6);
}

TEST(WheelPid, a_step_in_time_that_is_none_or_too_long_does_no_harm) {
  WheelPid pid{{.i = 1.0, .d = 1.0}};
  static_cast<void>(pid.update(1.0, 0.0, kPeriod));
  EXPECT_DOUBLE_EQ(pid.update(1.0, 0.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(pid.update(1.0, 0.5, -1.0), 0.0);
  EXPECT_DOUBLE_EQ(pid.update(1.0, 0.0, 5.0), WheelPid::kLongestStep);
}

TEST(BeyondDeadBand, skips_what_turns_nothing) {
  EXPECT_DOUBLE_EQ(beyond_dead_band(0.0, 0.2, 1.0), 0.0);
  EXPECT_NEAR(beyond_dead_band(1e-9, 0.2, 1.0), 0.2, 1e-6);
  EXPECT_DOUBLE_EQ(beyond_dead_band(0.5, 0.2, 1.0), 0.6);
  EXPECT_DOUBLE_EQ(beyond_dead_band(-0.5, 0.2, 1.0), -0.6);
  EXPECT_DOUBLE_EQ(beyond_dead_band(-1.0, 0.2, 1.0), -1.0);
  EXPECT_DOUBLE_EQ(beyond_dead_band(1.0, 0.2, 0.7), 0.7);
}

TEST(WheelWatch, finds_a_wheel_that_stands_at_its_limit) {
  WheelWatch watch{1.0};
  for (int cycle = 0; cycle < 49; ++cycle) EXPECT_EQ(watch.update(true, 0.0005, kPeriod), WheelWatch::Finding::None);
  for (int cycle = 0; cycle < 2; ++cycle) static_cast<void>(watch.update(true, 0.0, kPeriod));
  EXPECT_EQ(watch.update(true, 0.0, kPeriod), WheelWatch::Finding::Stands);
}

TEST(WheelWatch, finds_a_wheel_that_turns_against_its_motor) {
  WheelWatch watch{0.1};
  WheelWatch::Finding found = WheelWatch::Finding::None;
  for (int cycle = 0; cycle < 7; ++cycle) found = watch.update(true, -0.2, kPeriod);
  EXPECT_EQ(found, WheelWatch::Finding::Reversed);
}

TEST(WheelWatch, leaves_wheels_alone_that_turn_or_are_not_at_their_limit) {
  WheelWatch watch{0.1};
  for (int cycle = 0; cycle < 500; ++cycle) {
    EXPECT_EQ(watch.update(true, 0.02, kPeriod), WheelWatch::Finding::None) << "slow up a ramp";
  }
  for (int cycle = 0; cycle < 500; ++cycle)
    EXPECT_EQ(watch.update(cycle % 4 != 0, 0.0, kPeriod), WheelWatch::Finding::None);
  WheelWatch off{0.0};
  for (int cycle = 0; cycle < 500; ++cycle) EXPECT_EQ(off.update(true, 0.0, kPeriod), WheelWatch::Finding::None);
}

}  // namespace
}  // namespace nacelle::diff_drive
