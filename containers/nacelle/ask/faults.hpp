// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::ask {

/// Returns the faults of a container and how they are handled:
///
///   "components"        "node", "state", "policy", "restarts", "max_restarts", and where there is one "fault", "open_faults",
///                       "next_restart_s" and "last"
///   "history"           "number", "node", "code", "text", "callback", "time_ns"; of an open fault "open", and "lasted_s" if it is over
///   "left_out"          "node", "plugin", "why"
///   "container"         the container's own fault, or null
///   "robot_stopped_by"  a node, or null
///   "last_crash"        "text" and "file", or null
///
/// `container`: a name, or empty for the only one. Errors: as Nodes::ask_container().
[[nodiscard]] Result<nlohmann::json, Problem> list_faults(Nodes& nodes, const std::string& container);

/// Releases the emergency stops of a container; `topic`: on this topic only, unless it is empty. Returns "topics", each with "name" and
/// "readers". Errors: as Nodes::ask_container(); no component reads one; the container does not take this from the network.
[[nodiscard]] Result<nlohmann::json, Problem> release_emergency_stops(Nodes& nodes, const std::string& container,
                                                                      const std::string& topic);

}  // namespace nacelle::ask
