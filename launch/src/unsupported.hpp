// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/launch/plan.hpp"

namespace nacelle::launch {

// Everything that is known and yet refused stands in unsupported.cpp, so that bringing a word to life is one deletion.

/// Why an action is refused, and what to do instead; nullptr if it is not. The text is "<what>; <way out>".
[[nodiscard]] const char* refused_action(std::string_view name);
/// The same for an attribute that is not "false".
[[nodiscard]] const char* refused_attribute(std::string_view name);
/// The same for a substitution.
[[nodiscard]] const char* refused_substitution(std::string_view name);
/// What a whole plan asks for and the container cannot do yet.
[[nodiscard]] std::vector<Problem> refuse_unavailable(const Plan& plan);

}  // namespace nacelle::launch
