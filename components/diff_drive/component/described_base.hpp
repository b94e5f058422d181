// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diff_drive/component/diff_drive_options.hpp"
#include "nacelle/description/ros2_control.hpp"

namespace nacelle::diff_drive {

/// What the robot description says of the base: defaults below the parameters that are given, and what does not fit.
struct DescribedBase {
  DiffDriveOptions defaults;
  std::vector<Problem> problems;
  std::vector<Problem> warnings;
};

/// Names that the launch file gives, so that they need not be in the description.
struct GivenNames {
  std::optional<std::vector<std::string>> left_wheels, right_wheels;
  bool hardware = false;
};

/// Reads the <ros2_control> blocks that hold a wheel: the wheels' names, the plugin, the hardware's parameters under the names that
/// drivers of ros2_control use (device, baud_rate, timeout_ms, loop_rate, ...) and under our own; and checks the wheels against the joints.
/// Pure.
[[nodiscard]] DescribedBase described_base(const description::ControlDescription& description, const GivenNames& given);

/// Declares robot_description, robot_description_file and xacro_arguments on the node and reads the description that they name.
[[nodiscard]] DescribedBase read_described_base(Node& node);

}  // namespace nacelle::diff_drive
