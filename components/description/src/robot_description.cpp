// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/robot_description.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>

#include "nacelle/description/xacro.hpp"

namespace nacelle::description {
namespace {

constexpr std::size_t kLargest = 16U << 20U;  // a robot's URDF is some kilobytes; a wrong file may be anything

Result<std::string, Problem> text_of(const std::string& path) {
  errno = 0;
  std::ifstream in{path, std::ios::binary};
  if (!in) {
    return err(Problem{path, fmt::format("the robot description cannot be read: {}", std::strerror(errno)),
                       "see robot_description_file"});
  }
  std::string text;
  char piece[4096];
  while (in.read(piece, sizeof piece) || in.gcount() > 0) {
    text.append(piece, static_cast<std::size_t>(in.gcount()));
    if (text.size() > kLargest)
      return err(Problem{path, "is larger than 16 MiB, which no robot description is", "see robot_description_file"});
  }
  if (in.bad()) return err(Problem{path, "the robot description cannot be read", "is it a file?"});
  return text;
}

}  // namespace

std::string RobotDescription::place(std::size_t number, int line) const {
  if (number < places.size()) return places[number];
  return fmt::format("{}:{}", file.empty() ? "robot_description" : file, line);
}

Result<RobotDescription, Problem> read_description(const std::string& path,
                                                   const std::vector<std::string>& xacro_arguments) {
  auto text = text_of(path);
  if (!text) return err(text.error());
  if (!path.ends_with(".xacro")) return RobotDescription{std::move(text).value(), path, {}};
  std::map<std::string, std::string> arguments;
  for (const auto& argument : xacro_arguments) {
    const auto separator = argument.find(":=");
    if (separator == std::string::npos || separator == 0)
      return err(Problem{"parameter xacro_arguments", "'" + argument + "' is not name:=value", ""});
    arguments[argument.substr(0, separator)] = argument.substr(separator + 2);
  }
  auto expanded = expand_xacro(path, arguments, machine());
  if (!expanded) return err(expanded.error());
  return RobotDescription{std::move(expanded.value().urdf), path, std::move(expanded.value().places)};
}

}  // namespace nacelle::description
