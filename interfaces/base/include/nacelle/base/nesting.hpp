// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {

/// The deepest nesting of JSON, YAML and XML that is read. Copying, showing and destroying a value recurse: the stack has an end, and no
/// message, parameter or plan comes near this.
inline constexpr int kMostNesting = 64;

/// Looks at a JSON text before anything is built from it: counts brackets outside of strings.
///
/// Errors: deeper than kMostNesting, with the line. Whether the text is JSON is for the parser to say. Allocates: for an error only.
[[nodiscard]] Result<void, Problem> check_json_nesting(std::string_view text);

}  // namespace nacelle
