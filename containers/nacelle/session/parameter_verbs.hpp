// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/parameter.hpp"
#include "nacelle/runtime/introspection.hpp"
#include "nacelle/session/late_reply.hpp"

namespace nacelle::session {

class Session;

// Parameters of the nodes of this process. "name" is the node, as Container::find() takes it.
//
//   param.list     {"name"}                              "parameters": one object for each that is declared: "name", "type",
//                                                        "value" (JSON), "text" (YAML that reads back as the same), "description",
//                                                        "constraints", "read_only", "dynamic_typing", "from", "to", "step", "given"
//   param.set      {"name", "assignment": "rate:=5"}     refused as the node refuses it
//                  {"name", "assignments": [...]}        "results": "name" and "refusal" ("" if it is set) of each
//   param.delete   {"name", "parameter"}
[[nodiscard]] Answer reply_to_parameter_verb(Session& session, const std::string& verb, const nlohmann::json& request);

/// A value for people and scripts: JSON, with "NaN" and "Infinity" as texts.
[[nodiscard]] nlohmann::json json_of(const ParameterValue& value);
/// A row of param.list.
[[nodiscard]] nlohmann::json json_of(const runtime::ParameterReport& parameter);
/// Of "rate:=5". Errors: no assignment; one that gives no value.
[[nodiscard]] Result<Parameter, Problem> parameter_of_assignment(const std::string& assignment);

}  // namespace nacelle::session
