// SPDX-License-Identifier: Apache-2.0
#include "drive/model/square_course.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>
#include <random>
#include <vector>

namespace nacelle::drive {
namespace {

struct Robot {
  double lag_s = 0.05;            // wheels follow a command like this
  std::size_t delayed_steps = 3;  // from a pose to the moment that its command acts
  double speed_scale = 1.0, yaw_scale = 1.0;
  double stopped_at_s =
      1e9;  // from then on it follows no command until commands were zero for half a second (rearm: neutral)
};

struct Outcome {
  PlanarPose end;
  double seconds = 0, distance_m = 0;
  double top_speed = 0, top_yaw_rate = 0, top_acceleration = 0, top_yaw_acceleration = 0;
  CoursePhase phase{};
  std::vector<PlanarPose> corners;
};

/// Drives the course with a unicycle whose wheels lag behind, at 50 Hz, until it is over or `limit_s` has passed.
Outcome drive(SquareCourse& course, const Robot& robot, PlanarPose pose, double limit_s) {
  constexpr double kStep_s = 0.02;
  Outcome outcome;
  std::deque<VelocityCommand> under_way(robot.delayed_steps);
  VelocityCommand actual, last;
  MonotonicTime now{1s};
  unsigned sides = 0;
  double zero_for_s = 1, stops_at_s = robot.stopped_at_s;
  bool stopped = false;
  for (double t = 0; t < limit_s && !course.is_over(); t += kStep_s, now += 20ms) {
    const VelocityCommand command = course.step(pose, now);
    outcome.top_speed = std::max(outcome.top_speed, std::abs(command.speed_mps));
    outcome.top_yaw_rate = std::max(outcome.top_yaw_rate, std::abs(command.yaw_rate_rps));
    outcome.top_acceleration =
        std::max(outcome.top_acceleration, std::abs(command.speed_mps - last.speed_mps) / kStep_s);
    outcome.top_yaw_acceleration =
        std::max(outcome.top_yaw_acceleration, std::abs(command.yaw_rate_rps - last.yaw_rate_rps) / kStep_s);
    last = command;
    under_way.push_back(command);
    VelocityCommand acting = under_way.front();
    under_way.pop_front();
    zero_for_s = acting.speed_mps == 0 && acting.yaw_rate_rps == 0 ? zero_for_s + kStep_s : 0;
    if (t >= stops_at_s) {
      stopped = true;
      stops_at_s = 1e9;
    } else if (zero_for_s > 0.5) {
      stopped = false;
    }
    if (stopped) acting = {};
    const double share = 1 - std::exp(-kStep_s / robot.lag_s);
    actual.speed_mps += share * (robot.speed_scale * acting.speed_mps - actual.speed_mps);
    actual.yaw_rate_rps += share * (robot.yaw_scale * acting.yaw_rate_rps - actual.yaw_rate_rps);
    pose.yaw_rad += actual.yaw_rate_rps * kStep_s;
    pose.x_m += actual.speed_mps * std::cos(pose.yaw_rad) * kStep_s;
    pose.y_m += actual.speed_mps * std::sin(pose.yaw_rad) * kStep_s;
    outcome.seconds = t;
    if (course.sides_done() != sides) {
      sides = course.sides_done();
      outcome.corners.push_back(pose);
    }
  }
  outcome.end = pose;
  outcome.phase = course.phase();
  outcome.distance_m = course.distance_m();
  return outcome;
}

double angle_between(double a, double b) { return std::abs(std::remainder(a - b, 2 * std::numbers::pi)); }

TEST(SquareCourse, ends_where_and_as_it_began_for_any_start_and_any_robot_near_the_nominal_one) {
  const unsigned seed = 5;
  std::mt19937 random{seed};
  std::uniform_real_distribution<double> unit{-1, 1};
  for (int i = 0; i < 40; ++i) {
    const PlanarPose start{3 * unit(random), 3 * unit(random), 3 * unit(random)};
    const Robot robot{0.05 + 0.02 * unit(random), random() % 5, 1 + 0.05 * unit(random), 1 + 0.05 * unit(random)};
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", case " << i);
    SquareCourse course{{}};
    const Outcome outcome = drive(course, robot, start, 60);
    EXPECT_EQ(outcome.phase, CoursePhase::Done);
    EXPECT_LT(std::hypot(outcome.end.x_m - start.x_m, outcome.end.y_m - start.y_m), 0.03);
    EXPECT_LT(angle_between(outcome.end.yaw_rad, start.yaw_rad), 0.04);
    EXPECT_NEAR(outcome.distance_m, 4.0, 0.1);
    EXPECT_LT(outcome.seconds, 45);
  }
}

TEST(SquareCourse, turns_at_the_corners_of_a_metre_square) {
  SquareCourse course{{}};
  const Outcome outcome = drive(course, {}, {}, 60);
  const PlanarPose corners[] = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  ASSERT_EQ(outcome.corners.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(std::hypot(outcome.corners[i].x_m - corners[i].x_m, outcome.corners[i].y_m - corners[i].y_m), 0.03)
        << "corner " << i;
  }
}

TEST(SquareCourse, keeps_its_limits) {
  const CourseOptions options;
  SquareCourse course{options};
  const Outcome outcome = drive(course, {}, {}, 60);
  EXPECT_LE(outcome.top_speed, options.speed_mps + 1e-9);
  EXPECT_GT(outcome.top_speed, 0.9 * options.speed_mps);
  EXPECT_LE(outcome.top_yaw_rate, options.yaw_rate_rps + 1e-9);
  EXPECT_LE(outcome.top_acceleration, options.acceleration_mps2 + 1e-6);
  EXPECT_LE(outcome.top_yaw_acceleration, options.yaw_acceleration_rps2 + 1e-6);
}

TEST(SquareCourse, asks_for_nothing_before_it_knows_where_it_is) {
  SquareCourse course{{}};
  const VelocityCommand first = course.step({5, 5, 1}, MonotonicTime{1s});
  EXPECT_EQ(first.speed_mps, 0);
  EXPECT_EQ(first.yaw_rate_rps, 0);
}

TEST(SquareCourse, gives_up_and_brakes_when_the_robot_does_not_move) {
  SquareCourse course{{}};
  Robot stuck;
  stuck.speed_scale = 0;
  const Outcome outcome = drive(course, stuck, {}, 60);
  EXPECT_EQ(outcome.phase, CoursePhase::Stalled);
  EXPECT_LT(outcome.seconds, 8);
  VelocityCommand command;
  for (int i = 0; i < 100; ++i) command = course.step({}, MonotonicTime{100s} + i * 20ms);
  EXPECT_EQ(command.speed_mps, 0);
}

TEST(SquareCourse, a_robot_that_was_stopped_on_its_way_is_given_the_rest_that_it_waits_for) {
  for (double stopped_at_s = 0.9; stopped_at_s < 20; stopped_at_s += 1.7) {
    SCOPED_TRACE(stopped_at_s);
    SquareCourse course{{}};
    Robot robot;
    robot.stopped_at_s = stopped_at_s;
    const Outcome outcome = drive(course, robot, {}, 60);
    EXPECT_EQ(outcome.phase, CoursePhase::Done);
    EXPECT_LT(std::hypot(outcome.end.x_m, outcome.end.y_m), 0.03);
  }
}

TEST(SquareCourse, a_late_call_is_no_jump_of_the_command) {
  SquareCourse course{{}};
  MonotonicTime now{1s};
  PlanarPose pose;
  double last = 0;
  for (int i = 0; i < 200; ++i, now += 20ms) last = course.step(pose, now).speed_mps;
  const double after_a_pause = course.step(pose, now + 2s).speed_mps;
  EXPECT_LE(std::abs(after_a_pause - last), 0.1 * CourseOptions{}.acceleration_mps2 + 1e-9);
}

}  // namespace
}  // namespace nacelle::drive
