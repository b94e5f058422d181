// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace nacelle::session {

class Session;

/// Carries out one request of the control socket and says how it went. May take as long as a component takes.
/// Errors: a reply with "ok": false; nlohmann's exceptions for fields of a wrong type.
[[nodiscard]] nlohmann::json reply_to_verb(Session& session, const std::string& verb, const nlohmann::json& request);

}  // namespace nacelle::session
