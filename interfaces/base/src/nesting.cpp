// SPDX-License-Identifier: Apache-2.0
#include "nacelle/base/nesting.hpp"

#include <string>

namespace nacelle {

Result<void, Problem> check_json_nesting(std::string_view text) {
  int depth = 0, line = 1;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMostNesting) {
        return err(Problem{"line " + std::to_string(line),
                           "lists and objects are nested deeper than " + std::to_string(kMostNesting) + " levels", ""});
      }
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return {};
}

}  // namespace nacelle
