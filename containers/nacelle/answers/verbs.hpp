// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "answers/robot.hpp"
#include "desk/late_reply.hpp"
#include "nacelle/msgs/type_library.hpp"

namespace nacelle::answers {

/// Carries out one request of the control socket and says how it went; what waits for a service is answered later.
/// Errors: a reply with "ok": false; nlohmann's exceptions for fields of a wrong type.
[[nodiscard]] desk::Answer reply_to_verb(Robot& robot, msgs::TypeLibrary& types, const std::string& verb,
                                         const nlohmann::json& request);

}  // namespace nacelle::answers
