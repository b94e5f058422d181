// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "answers/robot.hpp"

namespace nacelle::answers {

/// Returns nodes, endpoints and services in one answer. Commands and completion filter it.
///
///   "nodes"      "node", "id" (0: not a component), "managed", "state", "plugin", "isolated", "hidden" (a tool's node)
///   "endpoints"  "topic", "type", "hash", "node", "publisher" (false: a subscription), "id", "elsewhere" (in another
///                process), "standard" (every node has it), "qos"; for a reader with a command timeout also
///                "command_timeout_s" and "command_parameter"
///   "services"   "name", "type", "node", "server" (false: a client), "open", "standard"
[[nodiscard]] nlohmann::json graph_of(Robot& robot);

}  // namespace nacelle::answers
