// SPDX-License-Identifier: Apache-2.0
#include "cli/typed_value.hpp"

#include <string_view>

#include "nacelle/base/names.hpp"
#include "nacelle/launch/parameter_value.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::cli {

Result<void, Problem> check_value(const std::string& text) {
  const std::string where = "value " + text;
  if (!text.empty() && std::string_view{"['\""}.find(text.front()) != std::string_view::npos) {
    if (const auto tree = parse_yaml(text, "value"); !tree) {
      return err(Problem{where, tree.error().what,
                         "close what is open; a text that begins so has quotes inside quotes: \"'[x'\""});
    }
  }
  if (const auto value = launch::value_of_text(text); !value)
    return err(Problem{where, value.error().what, value.error().way_out});
  return {};
}

std::string wrong_assignment(const std::string& text) {
  if (text.find(":=") == std::string::npos) return "'" + text + "' has no ':='; write name:=value";
  if (const auto parameter = launch::parse_parameter_assignment(text); !parameter)
    return Problem{"'" + text + "'", parameter.error().what, parameter.error().way_out}.text();
  const auto value = check_value(text.substr(text.find(":=") + 2));
  return value ? std::string{} : value.error().text();
}

std::string wrong_remap(const std::string& text) {
  if (text.find(":=") == std::string::npos) return "'" + text + "' has no ':='; write from:=to";
  const auto rule = parse_remap_rule(text);
  return rule ? std::string{} : Problem{"'" + text + "'", rule.error().what, rule.error().way_out}.text();
}

}  // namespace nacelle::cli
