// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Verbs of the network. `container`: a name, or empty for the only one.
namespace nacelle::ask {

/// Returns who may see a container's robot and why: the fields of nacelle_interfaces/msg/Network, and "container". What there is not is
/// null: "security", "problem", "figures", the limits of a row of "exports", "subject" and "ends" of "security".
/// Errors: as Nodes::ask_container().
[[nodiscard]] Result<nlohmann::json, Problem> get_network(Nodes& nodes, const std::string& container);

/// Shows the robot to other machines, or keeps it on its own; returns get_network()'s answer of afterwards.
/// Errors: as Nodes::ask_container(); the network cannot be had, and is as it was; the container does not take this from the network.
[[nodiscard]] Result<nlohmann::json, Problem> set_network(Nodes& nodes, const std::string& container, bool exported);

}  // namespace nacelle::ask
