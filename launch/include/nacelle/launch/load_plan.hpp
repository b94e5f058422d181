// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/qos/profiles.hpp"

namespace nacelle::launch {

/// All that a launch file can ask of the world. Tests give their own.
struct Environment {
  /// $(env NAME); nothing if it is not set.
  std::function<std::optional<std::string>(const std::string& name)> getenv;
  /// $(find-pkg-share PACKAGE): the folder with the package's data; nothing if there is no such package.
  std::function<std::optional<std::string>(const std::string& package)> find_package_share;
  /// The text of a file. Errors: `what` continues the sentence "the parameter file 'x' ...".
  std::function<Result<std::string, Problem>(const std::string& path)> read_file;
  /// What `profile:` in a `qos:` section may name, besides ROS 2's presets.
  ProfileSet profiles;
  /// What the launch file's own path is relative to: $(dirname) is absolute, as in ROS 2, so that it can stand in any path.
  std::string working_directory;
  /// Known packages, to name the nearest.
  std::vector<std::string> packages;
  /// Makes $(anon NAME) differ from that of another container: "<NAME>_<suffix>".
  std::string anonymous_suffix = "1";
};

/// Reads the process's environment and the file system (files up to 1 MiB); find_package_share finds nothing yet.
[[nodiscard]] Environment system_environment();

/// Reads a launch file (.yaml, .yml or .xml) and all that it includes into a plan.
///
/// `arguments` are the `name:=value` of the command line. Relative paths are relative to the file that names them; an
/// include is not a scope, as in ROS 2. What is in a branch that `if` or `unless` turns off is checked for unknown keys
/// and bad substitutions, but not evaluated.
/// Errors: every problem of all files, in the order found, each with "file:line" and the nearest valid name.
/// Never throws.
[[nodiscard]] Result<Plan, std::vector<Problem>> load_plan(const std::string& file,
                                                           const std::map<std::string, std::string>& arguments,
                                                           const Environment& environment);

/// Only the arguments that the files declare: those without a default need no value, and the nodes are not checked against
/// each other. The plan's other parts are as far as they are known. Errors: as load_plan(); none if a value is missing.
[[nodiscard]] Result<Plan, std::vector<Problem>> load_arguments(const std::string& file,
                                                                const std::map<std::string, std::string>& arguments,
                                                                const Environment& environment);

/// The same from text that is in memory; `file` tells the syntax and names the place.
[[nodiscard]] Result<Plan, std::vector<Problem>> load_plan_text(const std::string& text, const std::string& file,
                                                                const std::map<std::string, std::string>& arguments,
                                                                const Environment& environment);

/// Splits "name:=value" words of a command line. Errors: a word without ":=" or without a name.
[[nodiscard]] Result<std::map<std::string, std::string>, std::vector<Problem>> parse_arguments(
    const std::vector<std::string>& words);

}  // namespace nacelle::launch
