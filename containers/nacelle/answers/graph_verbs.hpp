// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "answers/robot.hpp"

namespace nacelle::answers {

/// Returns nodes, endpoints and services in one answer; commands and completion select what they show.
///
///   "nodes"      "node", "id" (0: no component), "managed", "state", "plugin", "isolated", "hidden" (a tool's)
///   "endpoints"  "topic", "type", "hash", "node", "publisher" (else a subscription), "id", "elsewhere" (in another process),
///                "qos", and for a reader that stops when messages stop "command_timeout_s" and "command_parameter"
///   "services"   "name", "type", "node", "server" (else a client), "open"
[[nodiscard]] nlohmann::json graph_of(Robot& robot);

}  // namespace nacelle::answers
