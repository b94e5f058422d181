// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/robot_description.hpp"

#include <fmt/format.h>

#include <map>

#include "nacelle/base/files.hpp"
#include "nacelle/description/xacro.hpp"

namespace nacelle::description {
Place RobotDescription::place(std::size_t number, int line) const {
  if (number < places.size()) return places[number];
  return {file.empty() ? "robot_description" : file, line};
}

Result<RobotDescription, Problem> read_description(const std::string& path,
                                                   const std::vector<std::string>& xacro_arguments) {
  auto text = read_regular_file(path);
  if (!text) return err(Problem{path, "the robot description " + text.error().what, "see robot_description_file"});
  if (!path.ends_with(".xacro")) return RobotDescription{std::move(text).value(), path, {}};
  std::map<std::string, std::string> arguments;
  for (const auto& argument : xacro_arguments) {
    const auto separator = argument.find(":=");
    if (separator == std::string::npos || separator == 0)
      return err(Problem{Place::of_parameter("xacro_arguments"), "'" + argument + "' is not name:=value", ""});
    arguments[argument.substr(0, separator)] = argument.substr(separator + 2);
  }
  auto expanded = expand_xacro(path, arguments, machine());
  if (!expanded) return err(expanded.error());
  return RobotDescription{std::move(expanded.value().urdf), path, std::move(expanded.value().places)};
}

}  // namespace nacelle::description
