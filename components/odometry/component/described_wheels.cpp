// SPDX-License-Identifier: Apache-2.0
#include "odometry/component/described_wheels.hpp"

#include "nacelle/description/ros2_control.hpp"

namespace nacelle::odometry {
namespace {

std::vector<std::string> given_or(const Node& node, const std::string& parameter, std::vector<std::string> otherwise) {
  const auto& overrides = node.parameters().overrides();
  const auto found = overrides.find(parameter);
  const auto* const names = found == overrides.end() ? nullptr : std::get_if<std::vector<std::string>>(&found->second);
  return names == nullptr ? std::move(otherwise) : *names;
}

}  // namespace

DescribedWheels read_described_wheels(Node& node) {
  const auto say = [](const char* text) { return ParameterDescriptor{.description = text, .read_only = true}; };
  DescribedWheels wheels;
  description::RobotDescription robot;
  robot.urdf = node.declare_parameter(
      "robot_description", "",
      say("The robot as URDF text: its wheels are the odometry's defaults, as they are the base's."));
  const auto file =
      node.declare_parameter("robot_description_file", "", say("A file that holds it, instead: URDF, or xacro."));
  const auto arguments = node.declare_parameter("xacro_arguments", std::vector<std::string>{},
                                                say("What the xacro file's arguments are, each \"name:=value\"."));
  if (!robot.urdf.empty() && !file.empty()) {
    wheels.problems.push_back(
        {Place::of_parameter("robot_description"), "robot_description_file is set, too", "give one of them"});
    return wheels;
  }
  if (!file.empty()) {
    auto read = description::read_description(file, arguments);
    if (!read) {
      wheels.problems.push_back(read.error());
      return wheels;
    }
    robot = std::move(read).value();
  }
  if (robot.urdf.empty()) return wheels;
  const auto control = description::read_ros2_control(robot);
  OdometryOptions& defaults = wheels.defaults;
  const auto& given = node.parameters().overrides();
  if (given.count("left_wheel_names") == 0 || given.count("right_wheel_names") == 0) {
    auto described = description::wheels_of(control);
    if (!described) {
      wheels.problems.push_back(described.error());
    } else if (!described->left.empty() || !described->right.empty()) {
      defaults.left_wheel_names = std::move(described->left);
      defaults.right_wheel_names = std::move(described->right);
    }
  }
  const auto lengths =
      description::wheel_lengths_of(control, {given_or(node, "left_wheel_names", defaults.left_wheel_names),
                                              given_or(node, "right_wheel_names", defaults.right_wheel_names)});
  defaults.wheel_separation_m = lengths.separation_m.value_or(defaults.wheel_separation_m);
  defaults.wheel_radius_m = lengths.radius_m.value_or(defaults.wheel_radius_m);
  return wheels;
}

}  // namespace nacelle::odometry
