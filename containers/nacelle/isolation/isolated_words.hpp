// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "nacelle/runtime/container.hpp"

namespace nacelle::isolation {

// Notes on the link between a container and the process of an isolated component: JSON objects.
//
//   container -> process   {"call": n, "do": "load", "plan": ..., "collect": bool}
//                          {"call": n, "do": "trigger", "transition": id}
//                          {"call": n, "do": "unload"}
//                          {"do": "stop"}, {"do": "limit", "ns": n}         executed at once, without an answer
//   process -> container   {"answer": n, "success": bool, "reason": text, "problem": ..., "info": ...}
//                          (after a load with "collect": also "faults")
//                          {"fault": info, "callback": text}                info: info_to_json()
//                          {"open_fault": {"node", "code", "text", "callback", "when_ns"; after its end "lasted_ns"}}
//                          {"state": [node, from, to, ns]}
//                          {"parameters": ..., "other_nodes": [name]}       after each change: parameters_to_json()
//
// plan_to_json() and parameters_to_json(): loading/plan_json.hpp.

[[nodiscard]] nlohmann::json faults_to_json(const std::vector<ParameterFault>& faults);
[[nodiscard]] std::vector<ParameterFault> faults_from_json(const nlohmann::json& rows);
/// Converts a component's info. Of its declarations, only the fields that a check needs are included, without parameter
/// values.
[[nodiscard]] nlohmann::json info_to_json(const runtime::ComponentInfo& info);
[[nodiscard]] runtime::ComponentInfo info_from_json(const nlohmann::json& row);

}  // namespace nacelle::isolation
