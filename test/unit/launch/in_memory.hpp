// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <utility>

#include "nacelle/launch/load_plan.hpp"

namespace nacelle::launch {

/// A world that holds these files and variables and one package, "robot_pkg".
inline Environment in_memory(std::map<std::string, std::string> files,
                             std::map<std::string, std::string> variables = {}) {
  Environment environment;
  environment.read_file = [files = std::move(files)](const std::string& path) -> Result<std::string, Problem> {
    const auto found = files.find(path);
    if (found == files.end()) return err(Problem{path, "cannot be read", ""});
    return found->second;
  };
  environment.getenv = [variables = std::move(variables)](const std::string& name) {
    const auto found = variables.find(name);
    return found == variables.end() ? std::nullopt : std::optional<std::string>(found->second);
  };
  environment.find_package_share = [](const std::string& package) {
    return package == "robot_pkg" ? std::optional<std::string>("/share/robot_pkg") : std::nullopt;
  };
  environment.packages = {"robot_pkg"};
  return environment;
}

/// All problems, one per line; "ok" for a plan. Each has a code.
inline std::string problems_of(const Result<Plan, std::vector<Problem>>& plan) {
  if (plan) return "ok";
  std::string all;
  for (const auto& problem : plan.error()) {
    EXPECT_FALSE(problem.code.empty()) << problem.text();
    all += problem.text() + "\n";
  }
  return all;
}

/// A launch file of one container with this inside the list of composable nodes.
inline std::string with_components(const std::string& lines) {
  return "launch:\n- node_container:\n    name: robot\n    composable_node:\n" + lines;
}

}  // namespace nacelle::launch
