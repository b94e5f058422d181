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

/// What a launch file's component asks of the container. Pure.
[[nodiscard]] runtime::LoadRequest load_request_of(const launch::ComponentPlan& plan);

/// What a launch file's program asks of the operating system. `own_program` is the path of the running `nacelle`: a node of
/// the package "nacelle" is the program itself, and gets told whom to die with. Pure but for the search in the file system.
///
/// Errors: a package's program is not found in <prefix>/lib/<package>/ of any of `prefixes`.
[[nodiscard]] Result<process::ProgramSpec, Problem> program_spec_of(const launch::ProgramPlan& plan,
                                                                    const std::string& own_program,
                                                                    const std::vector<std::string>& prefixes);

/// The container's own parameters, in seconds: `hang_after`, `handover_after`, `transition_timeout`. Errors: all that is wrong, each
/// where the parameter stands (`where` for one without a place): another name, no positive number. Pure.
[[nodiscard]] Result<runtime::ContainerOptions, std::vector<Problem>> container_options_of(
    const std::vector<launch::Parameter>& parameters, const Place& where);

}  // namespace nacelle::loading
