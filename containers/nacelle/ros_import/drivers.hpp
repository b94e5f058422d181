// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/parameter_value.hpp"
#include "ros_import/ros_import.hpp"

namespace nacelle::ros_import {

/// A parameter of a ROS 2 driver and its counterpart in Nacelle. The head of drivers.yaml explains the fields.
struct Key {
  std::string name;  ///< "wheel_radius"; "odom#_config" for any number; "linear.x.*" for any ending.
  Fate fate = Fate::Kept;
  std::vector<std::string> nodes;  ///< Nacelle's nodes; empty: the driver's own.
  std::string to;                  ///< The parameter's name there; empty: the same.
  std::string text, usual_text, absent_text, otherwise, also, form;
  ParameterValue usual, absent, most, joined;  ///< Not set: none.
  std::map<std::string, ParameterValue, std::less<>> values;
  bool any_case = false;
};

struct Driver {
  std::string name;                        ///< "robot_localization"
  std::vector<std::string> named, hinted;  ///< In lower case.
  std::string node;                        ///< Nacelle's.
  bool shared = false;
  std::string controls;
  std::vector<Key> keys;
};

/// The translation rules as data.
struct Table {
  std::vector<Key> every_node;
  std::vector<std::string> generic, double_lists;
  std::vector<Driver> drivers;
};

/// Parses drivers.yaml.
/// Errors: each row without exactly one fate, without a required reason, or with an unknown key; with file:line.
[[nodiscard]] Result<Table, std::vector<Problem>> read_table(std::string_view yaml, const std::string& file_name);

/// The text of drivers.yaml at build time.
extern const std::string_view kDriversYaml;
/// Returns the table of kDriversYaml, which is parsed at the first call. Threads: any.
[[nodiscard]] const Table& table();
[[nodiscard]] const std::vector<Driver>& drivers();

/// Returns the parameter's row, or null. In a row, '#' stands for digits and '*' for any text.
[[nodiscard]] const Key* find_key(const Driver& driver, std::string_view name);
/// Returns the row of a parameter that any node may have, or null.
[[nodiscard]] const Key* find_common_key(std::string_view name);

}  // namespace nacelle::ros_import
