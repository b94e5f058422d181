// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "in_memory.hpp"
#include "support/places.hpp"

namespace nacelle::launch {
namespace {

const std::string kFile = test::source("launch/robot.launch.yaml");
const std::string kTeleop = test::source("launch/teleop.launch.yaml");

Plan loaded(const std::string& file, const std::map<std::string, std::string>& arguments) {
  Environment environment = system_environment();
  environment.getenv = [](const std::string&) { return std::optional<std::string>(); };
  auto plan = load_plan(file, arguments, environment);
  EXPECT_TRUE(plan) << problems_of(plan);
  return plan ? std::move(*plan) : Plan{};
}

Plan robot(const std::map<std::string, std::string>& arguments) { return loaded(kFile, arguments); }

ParameterValue value_of(const Plan& plan, const std::string& node, const std::string& parameter) {
  const auto* component = plan.find(node);
  if (component == nullptr) return {};
  for (const auto& p : component->parameters) {
    if (p.name == parameter) return p.value;
  }
  return {};
}

TEST(RobotLaunch, holds_the_robots_nodes) {
  std::vector<std::string> names;
  for (const auto& component : robot({}).components) names.push_back(component.full_name());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"/camera", "/detector", "/diff_drive", "/ekf", "/imu", "/lidar",
                                             "/monitor", "/monitor_2", "/odometry", "/transforms"}));
}

Result<Plan, std::vector<Problem>> load(const std::string& text) {
  return load_plan("a.launch.yaml", {}, in_memory({{"a.launch.yaml", text}}));
}

TEST(LookLaunch, is_a_component_that_need_not_start) {
  const auto plan = load("launch:\n- look: {port: 8081, address: 0.0.0.0}\n- node_container: {name: robot}\n");
  ASSERT_TRUE(plan) << problems_of(plan);
  ASSERT_NE(plan->find("/look"), nullptr);
  EXPECT_EQ(plan->find("/look")->plugin, "nacelle::look::LookComponent");
  EXPECT_FALSE(plan->find("/look")->required);
  EXPECT_EQ(value_of(*plan, "/look", "port"), ParameterValue(std::int64_t{8081}));
  EXPECT_EQ(value_of(*plan, "/look", "address"), ParameterValue(std::string("0.0.0.0")));
  EXPECT_FALSE(load("launch:\n- look: {port: 65536}\n"));
  EXPECT_FALSE(load("launch:\n- look: {name: 'a b'}\n"));
}

TEST(RobotLaunch, comes_without_the_detector) {
  const Plan plan = robot({{"detector", "false"}});
  EXPECT_EQ(plan.components.size(), 9U);
  EXPECT_EQ(plan.find("/detector"), nullptr);
  EXPECT_TRUE(plan.unused_sections.empty());
  ASSERT_NE(plan.find("/camera"), nullptr);
  EXPECT_EQ(plan.find("/camera")->after.at(0).node, "/monitor");
}

TEST(RobotLaunch, starts_the_world_and_takes_its_devices_in_simulation) {
  const Plan plan = robot({{"sim_dir", "/run/w"}, {"seed", "7"}});
  ASSERT_EQ(plan.programs.size(), 1U);
  EXPECT_EQ(plan.programs[0].command_arguments(),
            (std::vector<std::string>{"sim", "world", "--dir", "/run/w", "--seed", "7"}));
  EXPECT_EQ(value_of(plan, "/lidar", "port_name"), ParameterValue(std::string("/run/w/lidar")));
  EXPECT_EQ(value_of(plan, "/imu", "port"), ParameterValue(std::string("/run/w/imu")));
  EXPECT_EQ(value_of(plan, "/diff_drive", "serial_port"), ParameterValue(std::string("/run/w/base")));
}

TEST(RobotLaunch, takes_the_named_devices_on_a_robot) {
  const Plan plan = robot({{"sim", "false"}, {"lidar_port", "/dev/serial/by-id/x"}, {"camera_device", "/dev/video2"}});
  EXPECT_TRUE(plan.programs.empty());
  EXPECT_EQ(value_of(plan, "/lidar", "port_name"), ParameterValue(std::string("/dev/serial/by-id/x")));
  EXPECT_EQ(value_of(plan, "/camera", "video_device"), ParameterValue(std::string("/dev/video2")));
}

TEST(RobotLaunch, uses_every_section_of_its_parameter_file) { EXPECT_TRUE(robot({}).unused_sections.empty()); }

TEST(RobotLaunch, activates_readers_before_writers) {
  const Plan plan = robot({});
  // Who writes what another reads; the monitors read everything.
  const std::pair<const char*, const char*> reader_before_writer[]{
      {"/ekf", "/odometry"},         {"/odometry", "/diff_drive"}, {"/ekf", "/imu"},
      {"/detector", "/camera"},      {"/monitor", "/ekf"},         {"/monitor_2", "/lidar"},
      {"/transforms", "/diff_drive"}};
  std::map<std::string, std::vector<std::string>> before;
  for (const auto& component : plan.components) {
    for (const auto& condition : component.after) before[component.full_name()].push_back(condition.node);
  }
  for (const auto& [reader, writer] : reader_before_writer) {
    std::vector<std::string> reached{writer};
    for (std::size_t i = 0; i < reached.size() && reached.size() < 1000; ++i) {
      for (const auto& next : before[reached[i]]) reached.push_back(next);
    }
    EXPECT_NE(std::find(reached.begin(), reached.end(), reader), reached.end()) << reader << " before " << writer;
  }
}

TEST(RobotLaunch, gives_a_thread_of_their_own_to_those_that_allocate) {
  for (const auto& component : robot({}).components) {
    const bool allocates = component.name == "detector" || component.name == "monitor" || component.name == "monitor_2";
    EXPECT_EQ(component.thread.own, allocates) << component.name;
  }
}

TEST(RobotLaunch, names_the_nearest_argument) {
  Environment environment = system_environment();
  const auto plan = load_plan(kFile, {{"lidar_prot", "x"}}, environment);
  EXPECT_EQ(problems_of(plan), kFile + ": the files declare no argument 'lidar_prot'; did you mean 'lidar_port'?\n");
}

TEST(TeleopLaunch, adds_the_gamepad_to_the_robot) {
  const Plan plan = loaded(kTeleop, {});
  EXPECT_EQ(plan.components.size(), 12U);
  EXPECT_TRUE(plan.unused_sections.empty());
  ASSERT_NE(plan.find("/joy_node"), nullptr);
  ASSERT_NE(plan.find("/teleop_twist_joy_node"), nullptr);
  EXPECT_EQ(plan.find("/teleop_twist_joy_node")->remaps.size(), 1U);
  EXPECT_EQ(plan.find("/joy_node")->after.at(0).node, "/teleop_twist_joy_node");
  EXPECT_EQ(value_of(plan, "/teleop_twist_joy_node", "axis_linear.x"), ParameterValue(std::int64_t{1}));
  EXPECT_EQ(value_of(plan, "/diff_drive", "topics.operator.topic"), ParameterValue(std::string("cmd_vel_teleop")));
}

TEST(TeleopLaunch, takes_the_arguments_of_the_robot_and_the_gamepads_name) {
  const Plan plan =
      loaded(kTeleop, {{"sim", "false"}, {"lidar_port", "/dev/serial/by-id/x"}, {"joy_name", "8BitDo Pro 2"}});
  EXPECT_TRUE(plan.programs.empty());
  EXPECT_EQ(value_of(plan, "/lidar", "port_name"), ParameterValue(std::string("/dev/serial/by-id/x")));
  EXPECT_EQ(value_of(plan, "/joy_node", "device_name"), ParameterValue(std::string("8BitDo Pro 2")));
}

}  // namespace
}  // namespace nacelle::launch
