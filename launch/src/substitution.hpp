// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::launch {

/// Answers $(name arguments...). A Problem without `what` is a failure that was reported before.
using SubstitutionLookup =
    std::function<Result<std::string, Problem>(const std::string& name, const std::vector<std::string>& arguments)>;

/// Longest text that a substitution may make; a chain of `let` that doubles itself ends here.
inline constexpr std::size_t kMaxSubstitutedBytes = std::size_t{64} * 1024;

/// Checks the syntax, the names and the numbers of arguments without evaluating anything.
/// Errors: a Problem without `where`.
[[nodiscard]] Result<void, Problem> check_template(std::string_view text);

/// The text with every $(...) replaced. Arguments are separated by spaces, may be quoted and may hold substitutions
/// themselves; "\$", "\\", "\'" and "\"" are the character behind the backslash.
[[nodiscard]] Result<std::string, Problem> substitute(std::string_view text, const SubstitutionLookup& lookup);

/// Splits a command line at spaces that are neither in quotes nor in a substitution; quotes are taken off.
/// The words are templates for substitute(). Errors: a quote or a "$(" that does not end.
[[nodiscard]] Result<std::vector<std::string>, Problem> split_words(std::string_view text);

/// True if the text holds a substitution.
[[nodiscard]] inline bool has_substitution(std::string_view text) { return text.find("$(") != std::string_view::npos; }

}  // namespace nacelle::launch
