// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "answers/robot.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "requests/late_reply.hpp"

namespace nacelle::answers {

/// Executes one request of the control socket and returns the reply. The reply to a request that waits for a service
/// follows later.
/// Errors: a reply with "ok": false; nlohmann's exceptions for fields of a wrong type.
[[nodiscard]] requests::Answer reply_to_verb(Robot& robot, msgs::TypeLibrary& types, const std::string& verb,
                                             const nlohmann::json& request);

}  // namespace nacelle::answers
