// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "rcl_interfaces/msg/parameter_value.hpp"

namespace nacelle::look {

/// A parameter as the Foxglove protocol writes it: {name, value, type}; `type` is there for numbers with a fraction and for bytes (base64).
/// A parameter without a value has none.
[[nodiscard]] nlohmann::json parameter_json(const std::string& name, const rcl_interfaces::msg::ParameterValue& value);

/// `type`: as above, or empty; null: not set. Nothing: it is no value of a parameter.
[[nodiscard]] std::optional<rcl_interfaces::msg::ParameterValue> parameter_value(const nlohmann::json& value,
                                                                                 const std::string& type);

}  // namespace nacelle::look
