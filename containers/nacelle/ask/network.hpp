// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Verbs of the network. `container`: a name, or empty for the only one.
namespace nacelle::ask {

/// Returns who can see a container's robot and why: the fields of nacelle_interfaces/msg/Network, and "container".
/// Absent values are null: "security", "problem", "figures", the limits of a row of "exports", "subject" and "ends" of
/// "security".
/// Errors: as Nodes::ask_container().
[[nodiscard]] Result<nlohmann::json, Problem> get_network(Nodes& nodes, const std::string& container);

/// Shows the robot to other machines, or restricts it to its own; returns the new state as get_network() does. Errors:
/// as Nodes::ask_container(); the network cannot be joined, and the previous mode stays in force; the container refuses
/// this from the network.
[[nodiscard]] Result<nlohmann::json, Problem> set_network(Nodes& nodes, const std::string& container, bool exported);

}  // namespace nacelle::ask
