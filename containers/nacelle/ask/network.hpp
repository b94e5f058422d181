// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Verbs of the network. `container`: a name, or empty for the only one.
namespace nacelle::ask {

/// Returns the network state of a container: the fields of nacelle_interfaces/msg/Network, and "container". Absent
/// values are null: "security", "problem", "figures", the limits of a row of "exports", "subject" and "ends" of
/// "security".
/// Errors: as Nodes::ask_container().
[[nodiscard]] Result<nlohmann::json, Problem> get_network(Nodes& nodes, const std::string& container);

/// Exports the robot to other machines, or restricts it to its own machine. Returns the new state as get_network()
/// does.
/// Errors: as Nodes::ask_container(); the network cannot be joined; the container refuses the request from the network.
/// On error the previous mode stays in force.
[[nodiscard]] Result<nlohmann::json, Problem> set_network(Nodes& nodes, const std::string& container, bool exported);

}  // namespace nacelle::ask
