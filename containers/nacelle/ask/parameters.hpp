// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ask/nodes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/parameter.hpp"

// Verbs of parameters, over the services of rcl_interfaces that every ROS 2 node offers.
namespace nacelle::ask {

/// Returns the declared parameters of a node, sorted by name. Each is an object:
///
///   "name", "type", "value" (JSON; "NaN" and "Infinity" as text), "text" (YAML that reads back as the same value),
///   "description", "constraints", "read_only", "dynamic_typing"; with a range also "from", "to" and "step"
///
/// `node`: its full name. Errors: as Nodes::call(); the parameters changed between two calls.
[[nodiscard]] Result<nlohmann::json, Problem> list_parameters(Nodes& nodes, const std::string& node);

/// Returns the names of a node's parameters. Errors: as Nodes::call().
[[nodiscard]] Result<std::vector<std::string>, Problem> parameter_names(Nodes& nodes, const std::string& node);

/// The result of setting one parameter.
struct ParameterOutcome {
  std::string name;
  std::string refusal;  ///< The node's reason; empty if it was set.
};
/// Sets each parameter on its own and returns the outcomes in the same order. A value of type NotSet undeclares a
/// parameter of dynamic type. Errors: as Nodes::call().
[[nodiscard]] Result<std::vector<ParameterOutcome>, Problem> set_parameters(Nodes& nodes, const std::string& node,
                                                                            const std::vector<Parameter>& parameters);
/// Sets one parameter. Errors: as set_parameters(); the node refuses the value; the node has no such parameter, with
/// the nearest name.
[[nodiscard]] Result<void, Problem> set_parameter(Nodes& nodes, const std::string& node, const Parameter& parameter);

/// Parses "rate:=5". Errors: not an assignment; no value.
[[nodiscard]] Result<Parameter, Problem> parameter_of_assignment(const std::string& assignment);
/// Returns a value as JSON, with "NaN" and "Infinity" as text.
[[nodiscard]] nlohmann::json json_of(const ParameterValue& value);
/// Returns rcl_interfaces/msg/ParameterValue as JSON.
[[nodiscard]] nlohmann::json message_of(const ParameterValue& value);
/// Returns the value of such a message.
[[nodiscard]] ParameterValue value_of(const nlohmann::json& message);

}  // namespace nacelle::ask
