// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ask {

/// Returns the faults of a container and how they are handled:
///
///   "components"        "node", "state", "policy", "restarts", "max_restarts"; if there are any also "fault",
///                       "open_faults", "next_restart_s" and "last"
///   "history"           "number", "node", "code", "text", "callback", "time_ns"; for an open fault also "open", and
///                       "lasted_s" if it is over
///   "left_out"          "node", "plugin", "why"
///   "container"         the container's own fault, or null
///   "robot_stopped_by"  a node, or null
///   "last_crash"        "text" and "file", or null
///
/// `container`: a name, or empty for the only one. Errors: as Nodes::ask_container().
[[nodiscard]] Result<nlohmann::json, Problem> list_faults(Nodes& nodes, const std::string& container);

/// Returns the topics on which an emergency stop of a container is set. Errors: as Nodes::ask_container().
[[nodiscard]] Result<std::vector<std::string>, Problem> emergency_stops(Nodes& nodes, const std::string& container);
/// Releases the emergency stops of a container on `topic`; if that is empty, on every emergency stop topic that a
/// component reads. Returns "topics", each with "name" and "readers".
/// Errors: as Nodes::ask_container(); `topic` is not an emergency stop; it is empty and no component reads one; the
/// container refuses the request from the network.
[[nodiscard]] Result<nlohmann::json, Problem> release_emergency_stops(Nodes& nodes, const std::string& container,
                                                                      const std::string& topic);

}  // namespace nacelle::ask
