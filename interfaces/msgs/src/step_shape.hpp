// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/msgs/message_type.hpp"

#include <cstddef>

namespace nacelle::msgs {

/// The width of the numbers of a type that is nothing but numbers of one width without holes (a point, a colour),
/// else 0. Many of them side by side are then the same bytes in memory as on the wire.
[[nodiscard]] inline std::size_t solid_width(const MessageType& type) {
  if (type.steps.size() != 1 || type.steps.front().kind != StepKind::Numbers) return 0;
  const Step& step = type.steps.front();
  return std::size_t{step.width} * step.count == type.size ? step.width : 0;
}

}  // namespace nacelle::msgs
