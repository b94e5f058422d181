// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nacelle_interfaces/msg/network.hpp>
#include <nlohmann/json_fwd.hpp>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::networking {

/// Converts Network::state() to a message; null becomes an empty list. Errors: a field that the message does not have,
/// or of another type. Pure.
[[nodiscard]] Result<nacelle_interfaces::msg::Network, Problem> network_message(nlohmann::json state);

}  // namespace nacelle::networking
