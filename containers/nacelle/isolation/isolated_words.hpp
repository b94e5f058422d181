// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "nacelle/runtime/container.hpp"

namespace nacelle::isolation {

// What a container and the process of an isolated component say to each other in notes of their link: JSON objects.
//
//   container -> process   {"call": n, "do": "load", "plan": ..., "collect": bool}
//                          {"call": n, "do": "trigger", "transition": id}
//                          {"call": n, "do": "unload"}
//                          {"do": "stop"}, {"do": "limit", "ns": n}         obeyed at once, without an answer
//   process -> container   {"answer": n, "success": bool, "reason": text, "way_out": text, "info": ...}
//                          (of a load that collects: also "faults")
//                          {"fault": info, "callback": text}                info: info_to_json()
//                          {"open_fault": {"node", "code", "text", "callback", "when_ns"; over: "lasted_ns"}}
//                          {"state": [node, from, to, ns]}
//                          {"parameters": ..., "other_nodes": [name]}       after each change: parameters_to_json()
//
// plan_to_json() and parameters_to_json(): loading/plan_json.hpp.

[[nodiscard]] nlohmann::json faults_to_json(const std::vector<ParameterFault>& faults);
[[nodiscard]] std::vector<ParameterFault> faults_from_json(const nlohmann::json& rows);
/// Of the declarations what a check looks at: names of unknown parameters and of services, frames.
[[nodiscard]] nlohmann::json info_to_json(const runtime::ComponentInfo& info);
[[nodiscard]] runtime::ComponentInfo info_from_json(const nlohmann::json& row);

}  // namespace nacelle::isolation
