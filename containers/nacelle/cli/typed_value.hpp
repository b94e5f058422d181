// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Checks values of parameters and rules from the command line before any query.
namespace nacelle::cli {

/// A parameter's value in YAML.
/// Errors: a list or a quoted text that is broken, which ROS 2's reader would take for a text; a list of several types. `where`
///         names the value.
[[nodiscard]] Result<void, Problem> check_value(const std::string& text);
/// Returns what is wrong with "name:=value", or nothing.
[[nodiscard]] std::string wrong_assignment(const std::string& text);
/// Returns what is wrong with "from:=to", or nothing.
[[nodiscard]] std::string wrong_remap(const std::string& text);

}  // namespace nacelle::cli
