// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/description/robot_description.hpp"

namespace nacelle::description {

/// <param name="...">value</param>
struct ControlParam {
  std::string name, value;
  Place where;
};
/// <command_interface name="velocity"> or <state_interface ...>
struct ControlInterface {
  std::string name;
  Place where;
};
/// A <joint> of a block.
struct ControlJoint {
  std::string name;
  Place where;
  std::vector<ControlInterface> commands, states;
  [[nodiscard]] bool has_command(const std::string& wanted) const;
};
/// One <ros2_control> block: a piece of hardware and the joints that it drives.
struct ControlBlock {
  std::string name, type;  ///< type: "system", "actuator" or "sensor"
  Place where;
  std::string plugin;
  Place plugin_where;
  std::vector<ControlParam> params;  ///< Of the hardware.
  std::vector<ControlJoint> joints;
};
/// A joint of the robot itself.
struct RobotJoint {
  std::string name, type;
  Place where;
  std::string parent, child;
  std::array<double, 3> xyz_m{}, rpy_rad{};  ///< X_parent_child at position 0.
};

/// What a robot description says for control.
struct ControlDescription {
  std::vector<ControlBlock> blocks;
  std::vector<RobotJoint> joints;
  std::map<std::string, double>
      radii_m;  ///< Of the links that are a cylinder or a sphere: of the collision's, else the visual's.
  std::vector<Problem>
      errors;  ///< What cannot be meant: a joint that the robot does not have, an interface without a name.
  std::vector<Problem> warnings;  ///< Tags that ros2_control does not know.

  [[nodiscard]] const RobotJoint* joint(const std::string& name) const;
  /// The joint in a block that has it, or null.
  [[nodiscard]] const ControlJoint* controlled(const std::string& name) const;
  /// y of the joint's origin in the frame of the root link, m; nothing for joints that go round in a circle.
  [[nodiscard]] std::optional<double> y_of(const RobotJoint& wanted) const;
};

/// Reads every <ros2_control> block, and checks it against the joints. Text that is not XML has neither; the code that
/// reads the robot's tree reports it.
///
/// Source of the format: "Hardware in ros2_control is described as URDF", control.ros.org (jazzy), hardware interface types.
/// Pure. Threads: any.
[[nodiscard]] ControlDescription read_ros2_control(const RobotDescription& description);

/// The driven wheels, left and right: continuous joints with a velocity command. A wheel with a positive y is on the left. If y is
/// zero, its name must contain "left" or "right". In the order in which the blocks name them.
struct Wheels {
  std::vector<std::string> left, right;
};
/// Errors: a wheel whose side is ambiguous.
[[nodiscard]] Result<Wheels, Problem> wheels_of(const ControlDescription& description);

/// What the description says of the wheels' sizes, as far as it does.
struct WheelLengths {
  std::optional<double> separation_m;  ///< Between the middles of left and right wheels.
  std::optional<double> radius_m;      ///< If all wheels have one.
};
/// Returns the parameters wheel_separation and wheel_radius of the hardware that has a wheel; else what the joints' places and
/// the links' cylinders give. Pure.
[[nodiscard]] WheelLengths wheel_lengths_of(const ControlDescription& description, const Wheels& wheels);

}  // namespace nacelle::description
