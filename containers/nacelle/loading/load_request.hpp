// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"
#include "process/foreign_programs.hpp"

namespace nacelle::loading {

/// Returns the container's load request for a launch file's component. Pure.
[[nodiscard]] runtime::LoadRequest load_request_of(const launch::ComponentPlan& plan);

/// Returns the parameters of a request as a launch file's component has them. Pure.
[[nodiscard]] std::vector<launch::Parameter> parameters_of(const runtime::LoadRequest& request);

/// Returns how to start a launch file's program. `own_program` is the path of the running `nacelle`: a node of the
/// package "nacelle" is the program itself, and gets an option to end with its parent. Pure except for the search in
/// the file system.
///
/// Errors: a package's program is not found in <prefix>/lib/<package>/ of any of `prefixes`.
[[nodiscard]] Result<process::ProgramSpec, Problem> program_spec_of(const launch::ProgramPlan& plan,
                                                                    const std::string& own_program,
                                                                    const std::vector<std::string>& prefixes);

/// The container's own parameters, in seconds: `hang_after`, `handover_after`, `transition_timeout`. Errors: every
/// wrong parameter with its place (`where` if it has none): another name, not a positive number. Pure.
[[nodiscard]] Result<runtime::ContainerOptions, std::vector<Problem>> container_options_of(
    const std::vector<launch::Parameter>& parameters, const Place& where);

}  // namespace nacelle::loading
