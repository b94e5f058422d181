// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "expression.hpp"
#include "nacelle/description/xacro.hpp"
#include "scope.hpp"
#include "trail.hpp"

namespace nacelle::description {

/// Evaluates the texts of a xacro file: ${expression}, $(substitution), arguments.
///
/// Errors: throws a Failure with the trail's place. Whatever was passed to the constructor must outlive it.
class Texts {
 public:
  Texts(Trail& trail, const std::map<std::string, std::string>& arguments, const XacroEnvironment& environment)
      : trail_(trail), given_(arguments), environment_(environment) {}

  /// The first declaration of an argument counts.
  void declare_argument(const std::string& name, std::optional<std::string> default_text) {
    defaults_.emplace(name, std::move(default_text));
  }
  /// The text with ${} and $() replaced; a single ${} keeps its type.
  Value evaluate_text(const std::string& text, const Scope& scope);
  std::string text_of(const std::string& text, const Scope& scope) { return to_text(evaluate_text(text, scope)); }
  /// A given argument that no file declares or asks for is a Failure.
  void check_arguments(const std::string& path) const;

 private:
  using Reading = std::pair<const Scope*, std::string>;

  std::string argument(const std::string& name);
  std::string substitution(const std::string& text);
  std::size_t end_of(const std::string& text, std::size_t at) const;
  Result<Value, std::string> value_named(std::string_view name, const Scope& scope);

  Trail& trail_;
  const std::map<std::string, std::string>& given_;
  const XacroEnvironment& environment_;
  std::map<std::string, std::optional<std::string>> defaults_;
  std::vector<std::string> asked_;
  std::vector<Reading> being_read_;
  std::size_t reads_ = 0;
};

}  // namespace nacelle::description
