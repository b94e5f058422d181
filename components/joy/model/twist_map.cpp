// SPDX-License-Identifier: Apache-2.0
#include "joy/model/twist_map.hpp"

#include <cmath>

namespace nacelle::joy {
namespace {

template <typename T>
T at(std::span<const T> values, std::int64_t index) {
  return index >= 0 && static_cast<std::uint64_t>(index) < values.size() ? values[static_cast<std::size_t>(index)]
                                                                         : T{};
}

}  // namespace

TwistMap::Outcome TwistMap::of(std::span<const float> axes, std::span<const std::int32_t> buttons) const {
  const bool turbo = at(buttons, settings_.turbo_button) != 0;
  if (!turbo && settings_.require_enable_button && at(buttons, settings_.enable_button) == 0) return {};
  const auto value = [&](const Direction& direction) {
    const double share = at(axes, direction.axis);
    // A message from elsewhere may hold anything.
    return std::isfinite(share) ? share * (turbo ? direction.turbo_scale : direction.scale) : 0.0;
  };
  Outcome outcome{true,
                  {value(settings_.x), value(settings_.y), value(settings_.z), value(settings_.roll),
                   value(settings_.pitch), value(settings_.yaw)}};
  if (settings_.inverted_reverse && outcome.twist.x < 0.0) outcome.twist.yaw = -outcome.twist.yaw;
  return outcome;
}

}  // namespace nacelle::joy
