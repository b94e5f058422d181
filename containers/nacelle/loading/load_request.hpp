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

/// Returns how to start a launch file's program. `own_program` is the path of the running `nacelle`. It is used for the
/// executable "nacelle" of the package "nacelle"; its `sim world` also gets an option to end with its parent. Pure
/// except for the search in the file system.
///
/// Errors: the package's program is not in <prefix>/lib/<package>/ of any of `prefixes`.
[[nodiscard]] Result<process::ProgramSpec, Problem> program_spec_of(const launch::ProgramPlan& plan,
                                                                    const std::string& own_program,
                                                                    const std::vector<std::string>& prefixes);

/// Returns the container's own parameters: `hang_after`, `handover_after`, `transition_timeout`, in seconds. Ignores
/// `use_sim_time`.
/// Errors: every wrong parameter with its place (`where` if it has none): an unknown name; a value outside 0.001 to
/// 3600; a `hang_after` that is not longer than `handover_after`. Pure.
[[nodiscard]] Result<runtime::ContainerOptions, std::vector<Problem>> container_options_of(
    const std::vector<launch::Parameter>& parameters, const Place& where);

}  // namespace nacelle::loading
