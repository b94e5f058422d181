// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "nacelle/node/node.hpp"

namespace nacelle::range {

/// A parameter with a text only.
[[nodiscard]] inline ParameterDescriptor described(std::string text) { return {.description = std::move(text)}; }
/// A number between two others.
[[nodiscard]] inline ParameterDescriptor within(std::string text, double from, double to) {
  return {.description = std::move(text), .floating_point_range = FloatingPointRange{from, to}};
}

}  // namespace nacelle::range
