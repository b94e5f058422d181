// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/policies/parameter_value.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::launch {

/// What a launch file's `type` asks for.
enum class ForcedType : std::uint8_t { None, Bool, Int, Float, Str, ListOfBool, ListOfInt, ListOfFloat, ListOfStr };

// How text becomes a value: rcl_yaml_param_parser's rules (jazzy). Unquoted Y/yes/true/on and their opposites are bool,
// what strtoll reads in base 0 is int64 (0x.., leading 0 is octal), what strtod reads is double (with .nan and .inf),
// everything else and everything quoted is string. Lists are homogeneous; an empty one is "not set".
// Errors: a Problem whose `where` is empty. Threads: pure.

/// The value of one unquoted scalar.
[[nodiscard]] ParameterValue value_of_scalar(std::string_view text);
/// The value of a text that stands for a whole YAML value: "3", "[1, 2]", "'text'".
[[nodiscard]] Result<ParameterValue, Problem> value_of_text(std::string_view text);
/// The value of a scalar or of a list of scalars; a type other than None is met exactly or refused.
[[nodiscard]] Result<ParameterValue, Problem> value_of_node(const YamlNode& node, ForcedType type = ForcedType::None);
/// The text as exactly that type: "5" as Str stays "5", "1" as Float is 1.0.
[[nodiscard]] Result<ParameterValue, Problem> value_of_type(std::string_view text, ForcedType type);
/// "bool", "int", "float", "str", "list_of_bool", ...
[[nodiscard]] Result<ForcedType, Problem> parse_forced_type(std::string_view word);

/// "speed:=0.3" as a command line writes it.
[[nodiscard]] Result<std::pair<std::string, ParameterValue>, Problem> parse_parameter_assignment(std::string_view text);
/// A parameter's name: not empty, dotted parts not empty, no space.
[[nodiscard]] Result<void, Problem> validate_parameter_name(std::string_view name);

/// The value as YAML that value_of_text() reads back as the same; "" when not set.
[[nodiscard]] std::string to_text(const ParameterValue& value);
/// "int", "string[]", "not set", ...
[[nodiscard]] std::string type_name(const ParameterValue& value);

}  // namespace nacelle::launch
