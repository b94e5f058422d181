// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Values of parameters and rules that a person types, looked at before anybody is asked.
namespace nacelle::cli {

/// A parameter's value in YAML.
/// Errors: a list or a quoted text that is broken, which ROS 2's reader would take for a text; a list of several types. `where`
///         names the value.
[[nodiscard]] Result<void, Problem> check_value(const std::string& text);
/// What is wrong with "name:=value", or nothing.
[[nodiscard]] std::string wrong_assignment(const std::string& text);
/// What is wrong with "from:=to", or nothing.
[[nodiscard]] std::string wrong_remap(const std::string& text);

}  // namespace nacelle::cli
