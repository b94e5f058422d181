// SPDX-License-Identifier: Apache-2.0
#include "replay/cast.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "nacelle/base/name_fault.hpp"

namespace nacelle::replay {
namespace {

const std::vector<Candidate> kRobot{
    {"/robot/base", {"/cmd_vel"}, {"/joint_states"}, "it opens /dev/ttyUSB0 (serial_port)", ""},
    {"/robot/odometry", {"/joint_states"}, {"/odom", "/tf"}, "", ""},
    {"/robot/ekf", {"/odom", "/imu", "/set_pose"}, {"/filtered", "/tf"}, "", ""},
    {"/robot/planner", {"/map"}, {"/cmd_vel"}, "", ""},
    {"/robot/broken", {"/imu"}, {}, "", "its constructor failed"}};

std::string running(const std::vector<Role>& roles) {
  std::string all;
  for (const auto& role : roles) {
    if (role.runs()) all += role.node.substr(role.node.rfind('/') + 1) + " ";
  }
  return all;
}

TEST(Cast, runs_what_reads_the_recording_or_what_another_one_publishes) {
  const auto roles = cast(kRobot, {"/joint_states"}, {});
  ASSERT_TRUE(roles);
  EXPECT_EQ(running(*roles), "odometry ekf ");
  EXPECT_EQ((*roles)[0].left_out, "driver: it opens /dev/ttyUSB0 (serial_port)");
  EXPECT_EQ((*roles)[3].left_out, "it reads nothing that was recorded");
  EXPECT_EQ((*roles)[4].left_out, "its constructor failed");
}

TEST(Cast, does_not_run_what_is_fed_by_what_does_not_run) {
  EXPECT_EQ(running(cast(kRobot, {"/cmd_vel"}, {}).value()), "") << "the base is a driver";
  EXPECT_EQ(running(cast(kRobot, {"/imu"}, {}).value()), "ekf ");
}

TEST(Cast, runs_the_named_ones_only_whatever_they_read) {
  EXPECT_EQ(running(cast(kRobot, {"/joint_states"}, {"planner", "/robot/ekf"}).value()), "ekf planner ");
}

TEST(Cast, refuses_names_of_drivers_and_of_nothing) {
  const auto driver = cast(kRobot, {"/cmd_vel"}, {"base"});
  ASSERT_FALSE(driver);
  EXPECT_EQ(driver.error().code, NameFault::Invalid);
  const auto none = cast(kRobot, {"/cmd_vel"}, {"/robot/efk"});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, NameFault::Unknown);
  EXPECT_EQ(none.error().way_out, "did you mean '/robot/ekf'?");
}

TEST(Cast, knows_what_nobody_publishes_and_who_would_have) {
  const std::set<std::string> recorded{"/imu"};
  const auto roles = cast(kRobot, recorded, {"ekf"});
  ASSERT_TRUE(roles);
  EXPECT_EQ(
      missing_topics(kRobot, *roles, recorded),
      (std::vector<MissingTopic>{{"/odom", {"/robot/ekf"}, "/robot/odometry"}, {"/set_pose", {"/robot/ekf"}, ""}}));
}

TEST(Cast, knows_who_misses_what_keeps_transforms) {
  std::vector<Candidate> robot = kRobot;
  robot[2].uses_frames = true;
  robot.push_back({"/robot/transforms", {"/tf", "/tf_static"}, {}, "", ""});
  const auto alone = cast(robot, {}, {"ekf"}), both = cast(robot, {}, {"ekf", "transforms"});
  EXPECT_EQ(without_transforms(robot, alone.value()), std::vector<std::string>{"/robot/ekf"});
  EXPECT_EQ(without_transforms(robot, both.value()), std::vector<std::string>{});
}

}  // namespace
}  // namespace nacelle::replay
