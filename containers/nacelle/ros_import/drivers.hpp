// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ros_import/ros_import.hpp"

namespace nacelle::ros_import {

/// A key of a ROS 2 driver and what Nacelle has for it: the tables are the translation.
struct Key {
  std::string_view name;  ///< "wheel_radius"; "odom#_config" for any number; "linear.x.*" for any end.
  Fate fate = Fate::Kept;
  /// "diff_drive odometry": the Nacelle nodes that get it; empty with Fate::Kept: the driver's own.
  std::string_view nodes{};
  std::string_view to{};    ///< Its name there; empty: the same.
  std::string_view text{};  ///< For people.
};

/// Something that the driver does unless it is told, and Nacelle does not.
struct Default {
  std::string_view node, name, value;  ///< value as YAML
  std::string_view text;
};

struct Driver {
  std::string_view name;        ///< "robot_localization"
  std::string_view full_names;  ///< What only names of its nodes hold, in lower case: "ekf_filter ukf_filter"
  std::string_view node_words;  ///< What names of its nodes hold, and of others': "ekf ukf"
  std::string_view nacelle_node;
  std::span<const Key> keys;
  std::span<const Default> defaults{};
};

[[nodiscard]] std::span<const Driver> drivers();

/// The key's row, or null. '#' in a row stands for digits, a '*' at its end for anything.
[[nodiscard]] const Key* find_key(const Driver& driver, std::string_view name);
/// Keys of any node.
[[nodiscard]] const Key* find_common_key(std::string_view name);

}  // namespace nacelle::ros_import
