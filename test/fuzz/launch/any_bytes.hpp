// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>
#include <string>

#include "nacelle/launch/load_plan.hpp"

namespace nacelle::launch {

/// Reads the bytes as a launch file in a world where every file that it names holds the same bytes.
/// The law: a plan, or at least one problem that says something; never a crash.
inline void read_any_bytes(const std::string& text, const std::string& file) {
  Environment environment;
  environment.getenv = [](const std::string& name) {
    return name.size() % 2 == 0 ? std::nullopt : std::optional<std::string>(name);
  };
  environment.find_package_share = [](const std::string& package) {
    return std::optional<std::string>("/share/" + package);
  };
  environment.read_file = [&text](const std::string&) -> Result<std::string, Problem> { return text; };
  const auto plan = load_plan_text(text, file, {{"sim", "true"}}, environment);
  if (plan) {
    if (to_text(*plan).empty()) std::abort();
    return;
  }
  if (plan.error().empty()) std::abort();
  for (const auto& problem : plan.error()) {
    if (problem.what.empty()) std::abort();
  }
}

}  // namespace nacelle::launch
