// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/motor_board.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace nacelle::simulation {
namespace {

UgvCommand parse(const char* line) {
  const auto command = UgvLineReader::parse(line);
  EXPECT_TRUE(command) << line;
  return command.value_or(UgvCommand{});
}

TEST(MotorBoard, aims_with_the_nominal_radius) {
  MotorBoard board{{}};
  board.on_command(parse(R"({"T":1,"L":0.33,"R":-0.066})"), 0ms);
  EXPECT_NEAR(board.left_target_rps(), 10.0, 1e-12);
  EXPECT_NEAR(board.right_target_rps(), -2.0, 1e-12);
}

TEST(MotorBoard, body_speeds_become_wheel_speeds) {
  MotorBoard board{{}};
  board.on_command(parse(R"({"T":13,"X":0.2,"Z":1.0})"), 0ms);
  EXPECT_NEAR(board.left_command_mps(), 0.05, 1e-12);
  EXPECT_NEAR(board.right_command_mps(), 0.35, 1e-12);
}

TEST(MotorBoard, its_watchdog_stops_the_wheels_after_three_seconds) {
  MotorBoard board{{}};
  board.on_command(parse(R"({"T":1,"L":0.3,"R":0.3})"), 1000ms);
  board.step(4000ms, 0.0, 0.0);
  EXPECT_EQ(board.left_command_mps(), 0.3);
  board.step(4001ms, 0.0, 0.0);
  EXPECT_EQ(board.left_command_mps(), 0.0);
  EXPECT_TRUE(board.stopped_by_watchdog());

  board.on_command(parse(R"({"T":1,"L":0.2,"R":0.2})"), 5000ms);
  board.step(5001ms, 0.0, 0.0);
  EXPECT_EQ(board.left_command_mps(), 0.2) << "the next motion command drives again";
}

TEST(MotorBoard, the_heartbeat_command_sets_the_watchdog) {
  MotorBoard board{{}};
  board.on_command(parse(R"({"T":136,"cmd":300})"), 0ms);
  board.on_command(parse(R"({"T":1,"L":0.3,"R":0.3})"), 0ms);
  board.step(300ms, 0.0, 0.0);
  EXPECT_EQ(board.left_command_mps(), 0.3);
  board.on_command(parse(R"({"T":130})"), 300ms);
  board.step(301ms, 0.0, 0.0);
  EXPECT_EQ(board.left_command_mps(), 0.0) << "only motion commands feed it";
}

TEST(MotorBoard, ignores_more_than_two_metres_a_second) {
  MotorBoard board{{}};
  board.on_command(parse(R"({"T":1,"L":0.3,"R":0.3})"), 0ms);
  board.on_command(parse(R"({"T":1,"L":0.1,"R":2.1})"), 1ms);
  EXPECT_EQ(board.left_command_mps(), 0.3);
  board.on_command(parse(R"({"T":1,"L":0.1})"), 1ms);
  EXPECT_EQ(board.left_command_mps(), 0.3) << "and half a command";
}

TEST(MotorBoard, an_emergency_stop_holds_until_it_is_released) {
  MotorBoard board{{}};
  board.on_command(parse(R"({"T":1,"L":0.3,"R":0.3})"), 0ms);
  board.on_command(parse(R"({"T":0})"), 1ms);
  EXPECT_EQ(board.left_command_mps(), 0.0);
  board.on_command(parse(R"({"T":1,"L":0.3,"R":0.3})"), 2ms);
  EXPECT_EQ(board.left_command_mps(), 0.0);
  board.on_command(parse(R"({"T":999})"), 3ms);
  EXPECT_EQ(board.left_command_mps(), 0.0) << "released is not driving";
  board.on_command(parse(R"({"T":1,"L":0.3,"R":0.3})"), 4ms);
  EXPECT_EQ(board.left_command_mps(), 0.3);
}

TEST(MotorBoard, odometry_comes_in_whole_counts_of_the_encoder) {
  MotorBoard board{{}};
  const double count_rad = 2 * std::numbers::pi / 1440;
  UgvFeedback feedback;
  board.step(10ms, 100.4 * count_rad, -100.4 * count_rad);
  board.describe(feedback);
  EXPECT_NEAR(feedback.odometry_left_m, 100 * count_rad * 0.033, 1e-12);
  EXPECT_NEAR(feedback.odometry_right_m, -101 * count_rad * 0.033, 1e-12);
  EXPECT_NEAR(feedback.left_mps, 100 * count_rad * 0.033 / 0.010, 1e-12);
}

TEST(MotorBoard, feedback_settings_are_the_hosts) {
  MotorBoard board{{}};
  EXPECT_TRUE(board.feedback_flows());
  EXPECT_FALSE(board.echoes());
  board.on_command(parse(R"({"T":131,"cmd":0})"), 0ms);
  board.on_command(parse(R"({"T":142,"cmd":90})"), 0ms);
  board.on_command(parse(R"({"T":143,"cmd":1})"), 0ms);
  EXPECT_FALSE(board.feedback_flows());
  EXPECT_EQ(board.feedback_interval(), 100ms);
  EXPECT_TRUE(board.echoes());
  EXPECT_TRUE(board.on_command(parse(R"({"T":130})"), 0ms));
}

}  // namespace
}  // namespace nacelle::simulation
