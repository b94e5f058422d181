// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

// Checks values of parameters and rules from the command line before any query.
namespace nacelle::cli {

/// Checks the text of a parameter's value, which is YAML.
/// Errors: a list or quoted text that is not closed, which ROS 2's reader would accept as plain text; a list of several
/// types. `where` names the value.
[[nodiscard]] Result<void, Problem> check_value(const std::string& text);
/// Returns the error of "name:=value", or an empty text.
[[nodiscard]] std::string wrong_assignment(const std::string& text);
/// Returns the error of "from:=to", or an empty text.
[[nodiscard]] std::string wrong_remap(const std::string& text);

}  // namespace nacelle::cli
