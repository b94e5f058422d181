// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "nacelle/node/parameter.hpp"
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

}  // namespace nacelle::session
