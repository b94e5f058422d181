// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <variant>

#include "nacelle/base/result.hpp"

namespace nacelle::description {

/// A value of Python's, as far as xacro files need them.
using Value = std::variant<bool, std::int64_t, double, std::string>;

/// As Python's str(): True, 3, 0.1, 2.0, text.
[[nodiscard]] std::string to_text(const Value& value);
/// The number, truth value or text that a property's or argument's text means, as xacro reads it.
[[nodiscard]] Value value_of(std::string_view text);
[[nodiscard]] bool is_true(const Value& value);

/// The value of a name; errors: why there is none.
using Names = std::function<Result<Value, std::string>(std::string_view name)>;

/// What is between ${ and }: arithmetic with Python's rules (3/2 is 1.5, -7//2 is -4, 2**3 is 8), comparisons, and, or, not,
/// `a if c else b`, texts in quotes, pi, e, inf, nan, tau, and the functions of Python's math module that URDFs use.
/// Errors: a sentence without a place. Depth is bounded.
[[nodiscard]] Result<Value, std::string> evaluate(std::string_view expression, const Names& names);

}  // namespace nacelle::description
