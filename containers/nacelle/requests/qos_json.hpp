// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "nacelle/qos/qos.hpp"

namespace nacelle::requests {

/// An endpoint's "qos" in the answer of the verb "graph"; times in seconds, null for "for ever".
[[nodiscard]] nlohmann::json json_of(const QoS& qos);

}  // namespace nacelle::requests
