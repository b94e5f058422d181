// SPDX-License-Identifier: Apache-2.0
#include "macro_parameters.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace nacelle::description {
namespace {

/// A value in quotes, or up to the next blank outside of ${}.
std::optional<std::string> taken_value(std::string_view& rest) {
  if (!rest.empty() && (rest.front() == '\'' || rest.front() == '"')) {
    const auto end = rest.find(rest.front(), 1);
    if (end == std::string_view::npos) return std::nullopt;
    std::string value(rest.substr(1, end - 1));
    rest.remove_prefix(end + 1);
    return value;
  }
  int depth = 0;
  std::size_t i = 0;
  for (; i < rest.size(); ++i) {
    const char c = rest[i];
    if (c == '{' || c == '(') ++depth;
    if (c == '}' || c == ')') --depth;
    if (depth <= 0 && (c == ' ' || c == '\t' || c == '\n' || c == '\r')) break;
  }
  std::string value(rest.substr(0, i));
  rest.remove_prefix(i);
  return value;
}

}  // namespace

Result<std::vector<Parameter>, std::string> macro_parameters(std::string_view text) {
  std::string_view rest = text;
  std::vector<Parameter> parameters;
  while (true) {
    const auto begin = rest.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return parameters;
    rest.remove_prefix(begin);
    Parameter made;
    while (rest.starts_with('*')) {
      ++made.stars;
      rest.remove_prefix(1);
    }
    const auto name_end = std::min(rest.find_first_of(" \t\r\n:="), rest.size());
    made.name = std::string(rest.substr(0, name_end));
    rest.remove_prefix(name_end);
    if (made.name.empty() || made.stars > 2)
      return err("the parameters are not understood at '" + std::string(rest.substr(0, 20)) + "'");
    if (rest.starts_with(":=") || rest.starts_with("=")) {
      rest.remove_prefix(rest.starts_with(":=") ? 2 : 1);
      made.has_default = true;
      if (rest.starts_with('^')) {
        made.from_outside = true;
        made.has_default = false;
        rest.remove_prefix(1);
        if (rest.starts_with('|')) {
          rest.remove_prefix(1);
          made.has_default = true;
        }
      }
      if (made.has_default) {
        auto value = taken_value(rest);
        if (!value) return err("a quotation mark in the parameters is not closed");
        made.default_text = std::move(*value);
      }
    }
    parameters.push_back(std::move(made));
  }
}

}  // namespace nacelle::description
