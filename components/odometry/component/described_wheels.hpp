// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "odometry/component/odometry_options.hpp"

namespace nacelle::odometry {

/// What the robot description says of the wheels: defaults below the parameters that are given.
struct DescribedWheels {
  OdometryOptions defaults;
  std::vector<Problem> problems;  ///< The description cannot be read, or the side of a wheel is ambiguous.
};

/// Declares robot_description, robot_description_file and xacro_arguments on the node, and reads the wheels' names from the
/// <ros2_control> blocks, their separation and radius from these, or from the joints and links.
[[nodiscard]] DescribedWheels read_described_wheels(Node& node);

}  // namespace nacelle::odometry
