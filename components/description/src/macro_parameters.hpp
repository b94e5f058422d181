// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/result.hpp"

namespace nacelle::description {

/// What a macro takes.
struct Parameter {
  std::string name;
  std::string default_text;
  bool has_default = false;
  bool from_outside = false;  ///< ^: the value of the same name where it is called
  int stars = 0;              ///< *: the next child, **: what is in the next child
};

/// Reads a macro's params: "a b:=1 c:='x y' *block **blocks d:=^ e:=^|2".
/// Errors: a sentence without a place.
[[nodiscard]] Result<std::vector<Parameter>, std::string> macro_parameters(std::string_view text);

}  // namespace nacelle::description
