// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::isolation {

// What a container and the process of an isolated component say to each other in notes of their link: JSON objects.
//
//   container -> process   {"call": n, "do": "load", "plan": ..., "collect": bool}   plan: plan_to_json()
//                          {"call": n, "do": "trigger", "transition": id}
//                          {"call": n, "do": "unload"}
//   process -> container   {"answer": n, "success": bool, "reason": text, "way_out": text, "info": ...}
//                          (of a load that collects: also "faults")
//                          {"fault": info, "callback": text}                info: info_to_json()
//
// Numbers are exact, but for floating-point ones, which travel as text in hexadecimal.

/// What loading needs of a plan; the rest is the container's business. Pure.
[[nodiscard]] nlohmann::json plan_to_json(const launch::ComponentPlan& plan);
/// Errors: nlohmann's exceptions and std::invalid_argument, for what is not such a plan.
[[nodiscard]] launch::ComponentPlan plan_from_json(const nlohmann::json& row);

[[nodiscard]] nlohmann::json faults_to_json(const std::vector<ParameterFault>& faults);
[[nodiscard]] std::vector<ParameterFault> faults_from_json(const nlohmann::json& rows);
/// Of the declarations what a check looks at: names of unknown parameters and of services, frames.
[[nodiscard]] nlohmann::json info_to_json(const runtime::ComponentInfo& info);
[[nodiscard]] runtime::ComponentInfo info_from_json(const nlohmann::json& row);

}  // namespace nacelle::isolation
