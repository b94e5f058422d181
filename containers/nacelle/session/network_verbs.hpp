// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace nacelle::session {

class Session;

/// `network`: who may see the robot. `network.show` with "exported": true or false changes it.
[[nodiscard]] nlohmann::json reply_to_network_verb(Session& session, const std::string& verb,
                                                   const nlohmann::json& request);

}  // namespace nacelle::session
