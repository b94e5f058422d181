// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "nacelle/qos/qos.hpp"

namespace nacelle::requests {

/// Returns an endpoint's "qos" for the answer of the verb "graph". Times are in seconds; null means unlimited.
[[nodiscard]] nlohmann::json json_of(const QoS& qos);

}  // namespace nacelle::requests
