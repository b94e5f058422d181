// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <rcl_interfaces/msg/parameter.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <string>

#include "nacelle/runtime/introspection.hpp"

// Parameters as rcl_interfaces' messages. Pure.
namespace nacelle::runtime {

/// Converts a message to a value. Errors: std::invalid_argument, with the parameter's name, for an unknown type.
[[nodiscard]] ParameterValue value_of(const std::string& name, const rcl_interfaces::msg::ParameterValue& message);
[[nodiscard]] rcl_interfaces::msg::ParameterValue message_of(const ParameterValue& value);
[[nodiscard]] rcl_interfaces::msg::Parameter message_of(const Parameter& parameter);
/// Uses the declared type, or the present type of a parameter with dynamic typing.
[[nodiscard]] rcl_interfaces::msg::ParameterDescriptor descriptor_of(const ParameterReport& parameter);

}  // namespace nacelle::runtime
