// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "nacelle/launch/parameter_file.hpp"
#include "nacelle/qos/yaml_tree.hpp"
#include "ros_import/drivers.hpp"

namespace nacelle::ros_import {

/// Returns the driver that a section is for, or null.
///
/// A node with the driver's own name always matches. For any other node, the driver must know at least half of the
/// parameters. In addition, a node whose name hints at the driver needs one parameter of it; any other node needs two
/// parameters that other drivers do not share. The best match is returned. Pure.
[[nodiscard]] const Driver* driver_of(const launch::ParameterSection& section, std::string_view node_name);

/// Returns the text with A to Z in lower case. Pure.
[[nodiscard]] std::string lower_case(std::string_view text);
/// Returns whether the section has only parameters of every node (`use_sim_time`). Pure.
[[nodiscard]] bool is_of_every_node(const launch::ParameterSection& section);

/// A list in a file: its line, and the last part of its parameter's name.
using ListPlace = std::pair<int, std::string>;
/// Rewrites whole numbers as 1.0 in lists of parameters of the type double[], because ROS 2 refuses such lists.
/// `changed` receives their places.
void widen_lists(YamlNode& node, std::set<ListPlace>& changed);
/// Returns the last part of a parameter's name: "initial_state". Pure.
[[nodiscard]] std::string last_part_of(std::string_view name);

}  // namespace nacelle::ros_import
