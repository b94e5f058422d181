// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "nacelle/msgs/type_library.hpp"
#include "nacelle/session/late_reply.hpp"

namespace nacelle::session {

class Session;

/// Calls a service of this process: {"service", "type", "request": message as JSON, "timeout_s"} is answered with "response".
///
/// The call is a message to the server's executor; a server that takes its time, or hangs, keeps nobody waiting but the caller.
[[nodiscard]] Answer call_service(Session& session, msgs::TypeLibrary& types, const nlohmann::json& request);

}  // namespace nacelle::session
