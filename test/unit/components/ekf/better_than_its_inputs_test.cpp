// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "assisted_drive.hpp"

// The figures of docs/ekf.md, "Better than its inputs": each switch where its assumption holds, and where it fails.
namespace nacelle::ekf {
namespace {

struct Switches {
  bool bias = false, standstill = false, slip = false;
};

AssistOptions options_of(const Switches& on) {
  AssistOptions options;
  options.gyro_bias.on = on.bias;
  options.standstill.on = on.standstill;
  options.slip.on = on.slip;
  return options;
}

struct Compared {
  DriveResult off, on;
};

Compared compare(const char* what, const DriveCase& how, const Switches& on) {
  const Compared both{drive_all_seeds(how, {}), drive_all_seeds(how, options_of(on))};
  std::printf("| %-62s | %8.2f | %8.2f | %7.3f | %7.3f |\n", what, both.off.yaw_rms_deg, both.on.yaw_rms_deg,
              both.off.position_rms_m, both.on.position_rms_m);
  return both;
}

// At most a fiftieth worse, or by less than the noise of an encoder.
void expect_no_harm(const Compared& both) {
  EXPECT_LE(both.on.yaw_rms_deg, both.off.yaw_rms_deg * 1.02 + 0.05);
  EXPECT_LE(both.on.position_rms_m, both.off.position_rms_m * 1.02 + 0.002);
}

std::array<double, 2> curves(double t_s) { return {0.4, std::fmod(t_s, 30.0) < 15.0 ? 0.3 : -0.2}; }
std::array<double, 2> curves_with_stops(double t_s) {
  if (std::fmod(t_s, 15.0) < 3.0) return {0.0, 0.0};
  return curves(t_s);
}
std::array<double, 2> standing(double) { return {0.0, 0.0}; }
std::array<double, 2> circle(double) { return {0.4, 0.5}; }
std::array<double, 2> straight_and_curves(double t_s) {
  const double p = std::fmod(t_s, 20.0);
  if (p < 2.0) return {0.0, 0.0};
  return {0.4, p < 11.0 ? 0.0 : 0.4};
}

DriveCase minute(std::function<std::array<double, 2>(double)> command) {
  DriveCase how;
  how.duration_s = 60.0;
  how.command = std::move(command);
  return how;
}
// Wheels, gyro and accelerometer are fused; the gyro is good.
DriveCase with_good_gyro() {
  DriveCase how = minute(straight_and_curves);
  how.gyro_bias_stddev_rps = 0.0005;
  how.wheels_yaw_rate = how.acceleration = true;
  return how;
}
std::function<Upset(double)> turned_by_hand(double rate_rps, double for_s) {
  return [=](double t_s) {
    Upset upset;
    if (t_s > 20.0 && t_s < 20.0 + for_s) upset.body_yaw_rate = rate_rps;
    return upset;
  };
}
// Up to `most` with a slope, from 5 s to `end_s` of each 20 s.
double burst(double t_s, double end_s, double most, double slope) {
  const double p = std::fmod(t_s, 20.0);
  return std::clamp(std::min((p - 5.0) * slope, (end_s - p) * slope), 0.0, most);
}

TEST(BetterThanItsInputs, gyro_bias_and_standstill_take_the_drift_out_of_the_heading) {
  const Switches both_on{.bias = true, .standstill = true};
  const Compared stops = compare("drives with stops of 3 s; bias and standstill", minute(curves_with_stops), both_on);
  EXPECT_GT(stops.off.yaw_rms_deg, 15.0);
  EXPECT_LT(stops.on.yaw_rms_deg, 0.5);
  EXPECT_LT(stops.on.position_rms_m, 0.05);
  const Compared stands = compare("stands for a minute; bias and standstill", minute(standing), both_on);
  EXPECT_LT(stands.on.yaw_rms_deg, 0.1);
  const Compared zero = compare("stands for a minute; standstill alone", minute(standing), {.standstill = true});
  EXPECT_LT(zero.on.yaw_rms_deg, 0.75 * zero.off.yaw_rms_deg);
}

TEST(BetterThanItsInputs, gyro_bias_does_no_harm_to_a_robot_that_never_stands) {
  expect_no_harm(
      compare("never stands, no other yaw; bias and standstill", minute(curves), {.bias = true, .standstill = true}));
  DriveCase how = minute(curves);
  how.wheels_yaw_rate = true;
  expect_no_harm(compare("never stands, wheels' yaw rate; bias", how, {.bias = true}));
  how.wheels_teach_bias = true;
  const Compared taught = compare("never stands, wheels' yaw rate teaches; bias", how, {.bias = true});
  EXPECT_LT(taught.on.yaw_rms_deg, 0.5 * taught.off.yaw_rms_deg);
  how = minute(circle);
  how.wheels_yaw_rate = true;
  how.separation_error = 0.1;
  expect_no_harm(compare("circles, wheel separation 10 % wrong; bias", how, {.bias = true}));
  how.wheels_teach_bias = true;
  const Compared mistaught = compare("circles, wheel separation 10 % wrong, teaches; bias", how, {.bias = true});
  EXPECT_GT(mistaught.on.yaw_rms_deg, mistaught.off.yaw_rms_deg) << "why wheels do not teach unless they are told to";
}

TEST(BetterThanItsInputs, standstill_does_no_harm_to_a_robot_that_is_moved_while_its_wheels_stand) {
  const Switches both_on{.bias = true, .standstill = true};
  DriveCase how = minute(standing);
  how.gyro_bias_stddev_rps = 0.002;
  how.upset = turned_by_hand(0.5, 3.14);
  expect_no_harm(compare("wheels stand, turned by 90 deg in 3 s; bias and standstill", how, both_on));
  how.upset = turned_by_hand(0.03, 20.0);
  expect_no_harm(compare("wheels stand, turned by 34 deg in 20 s; bias and standstill", how, both_on));
  expect_no_harm(compare("wheels stand, turned by 34 deg in 20 s; standstill alone", how, {.standstill = true}));
  how.upset = turned_by_hand(0.008, 20.0);
  expect_no_harm(compare("wheels stand, turned by 9 deg in 20 s; bias and standstill", how, both_on));
  how.upset = [](double t_s) {
    Upset upset;
    upset.body_speed = std::max(0.0, 1.0 - std::abs(t_s - 21.0));
    return upset;
  };
  expect_no_harm(compare("wheels stand, pushed by 1 m; bias and standstill", how, both_on));
}

TEST(BetterThanItsInputs, slip_detection_keeps_spinning_wheels_out_of_the_position) {
  DriveCase how = with_good_gyro();
  how.upset = [](double t_s) {
    Upset upset;
    upset.wheel_speed = burst(t_s, 6.5, 0.8, 4.0);
    return upset;
  };
  const Compared spin = compare("both wheels spin for 1.5 s, three times; slip", how, {.slip = true});
  EXPECT_LT(spin.on.position_rms_m, 0.2 * spin.off.position_rms_m);
  how.acceleration = false;
  const Compared alone = compare("the same, the filter without acceleration; slip", how, {.slip = true});
  EXPECT_LT(alone.on.position_rms_m, 0.2 * alone.off.position_rms_m);
  how = with_good_gyro();
  how.upset = [](double t_s) {
    Upset upset;
    upset.wheel_speed = burst(t_s, 7.0, 0.5, 1.0);
    return upset;
  };
  const Compared mild = compare("both wheels spin up by 1 m/s^2; slip", how, {.slip = true});
  EXPECT_LT(mild.on.position_rms_m, 0.5 * mild.off.position_rms_m);
  how.upset = [](double t_s) {
    Upset upset;
    upset.wheel_yaw_rate = burst(t_s, 6.5, 1.5, 8.0);
    upset.wheel_speed = 0.15 * upset.wheel_yaw_rate;
    return upset;
  };
  const Compared one = compare("one wheel spins for 1.5 s, three times; slip", how, {.slip = true});
  EXPECT_LT(one.on.position_rms_m, 0.5 * one.off.position_rms_m);
  const Compared all = compare("the same; all three", how, {.bias = true, .standstill = true, .slip = true});
  EXPECT_LT(all.on.position_rms_m, one.on.position_rms_m);
}

TEST(BetterThanItsInputs, slip_detection_does_no_harm_without_slip_or_with_a_bad_imu) {
  const Switches slip{.slip = true};
  expect_no_harm(compare("no slip; slip", with_good_gyro(), slip));
  DriveCase how = with_good_gyro();
  how.gyro_bias_rps = 0.3;
  expect_no_harm(compare("gyro with a bias of 0.3 rad/s; slip", how, slip));
  how = with_good_gyro();
  how.gyro_scale = 0.0;
  expect_no_harm(compare("dead gyro; slip", how, slip));
  how.gyro_scale = 0.5;
  expect_no_harm(compare("gyro that shows half; slip", how, slip));
  how.gyro_scale = -1.0;
  expect_no_harm(compare("gyro with the wrong sign; slip", how, slip));
  const auto ramp = [](double tilt_rad) {
    return [=](double t_s) {
      const double p = std::fmod(t_s, 20.0);
      Upset upset;
      if (p > 8.0 && p < 14.0) upset.tilt_rad = tilt_rad;
      return upset;
    };
  };
  how = with_good_gyro();
  how.upset = ramp(0.0873);
  expect_no_harm(compare("ramps of 5 deg, gravity not taken off; slip", how, slip));
  how.upset = ramp(0.175);
  expect_no_harm(compare("ramps of 10 deg, gravity not taken off; slip", how, slip));
}

}  // namespace
}  // namespace nacelle::ekf
