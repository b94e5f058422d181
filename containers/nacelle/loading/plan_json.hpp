// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "nacelle/launch/plan.hpp"

// A component's plan as JSON, for state files and for its own process. Integers are exact; floating-point numbers are
// text in hexadecimal.
namespace nacelle::loading {

/// Returns what load_request_of() needs of a plan. Pure.
[[nodiscard]] nlohmann::json plan_to_json(const launch::ComponentPlan& plan);
/// Errors: nlohmann's exceptions and std::invalid_argument for invalid input.
[[nodiscard]] launch::ComponentPlan plan_from_json(const nlohmann::json& row);

[[nodiscard]] nlohmann::json parameters_to_json(const std::vector<launch::Parameter>& parameters);
/// Errors: as plan_from_json().
[[nodiscard]] std::vector<launch::Parameter> parameters_from_json(const nlohmann::json& rows);

}  // namespace nacelle::loading
