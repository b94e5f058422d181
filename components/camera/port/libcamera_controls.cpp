// SPDX-License-Identifier: Apache-2.0
#include "camera/port/libcamera_controls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nacelle::camera {
namespace {

constexpr double kThousand = 1000;

std::int64_t in_thousandths(float number) {
  if (std::isnan(number)) return 0;
  constexpr double kMost = 1e15;  // beyond what a parameter is set to, within what a double counts exactly
  return static_cast<std::int64_t>(std::llround(std::clamp(double{number} * kThousand, -kMost, kMost)));
}

/// Nothing: it is no number.
std::optional<std::int64_t> number_of(const ::libcamera::ControlValue& value) {
  if (value.isArray()) return std::nullopt;
  switch (value.type()) {
    case ::libcamera::ControlTypeBool: return value.get<bool>() ? 1 : 0;
    case ::libcamera::ControlTypeByte: return value.get<std::uint8_t>();
    case ::libcamera::ControlTypeInteger32: return value.get<std::int32_t>();
    case ::libcamera::ControlTypeInteger64: return value.get<std::int64_t>();
    case ::libcamera::ControlTypeFloat: return in_thousandths(value.get<float>());
    default: return std::nullopt;
  }
}

}  // namespace

std::string control_parameter_name(std::string_view control_name) {
  std::string name;
  for (const char c : control_name) {
    const bool capital = c >= 'A' && c <= 'Z';
    if (capital && !name.empty() && name.back() != '_') name += '_';
    const bool plain = capital || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    name += capital ? static_cast<char>(c | 0x20) : plain ? c : '_';
  }
  return name;
}

std::vector<Control> list_controls(const ::libcamera::ControlInfoMap& controls) {
  std::vector<Control> all;
  for (const auto& [id, info] : controls) {
    const auto least = number_of(info.min()), most = number_of(info.max());
    if (id->isArray() || !least || !most) continue;
    Control control;
    control.id = id->id();
    control.name = control_parameter_name(id->name());
    if (id->type() == ::libcamera::ControlTypeFloat) control.name += "_milli";
    control.is_switch = id->type() == ::libcamera::ControlTypeBool;
    control.least = *least;
    control.most = *most;
    control.value = number_of(info.def()).value_or(*least);
    control.step = 1;
    all.push_back(std::move(control));
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return all;
}

std::optional<::libcamera::ControlValue> control_value(const ::libcamera::ControlInfoMap& controls, unsigned id,
                                                       std::int64_t value) {
  const auto found = controls.find(id);
  if (found == controls.end()) return std::nullopt;
  switch (found->first->type()) {
    case ::libcamera::ControlTypeBool: return ::libcamera::ControlValue{value != 0};
    case ::libcamera::ControlTypeByte: return ::libcamera::ControlValue{static_cast<std::uint8_t>(value)};
    case ::libcamera::ControlTypeInteger32: return ::libcamera::ControlValue{static_cast<std::int32_t>(value)};
    case ::libcamera::ControlTypeInteger64: return ::libcamera::ControlValue{value};
    case ::libcamera::ControlTypeFloat:
      return ::libcamera::ControlValue{static_cast<float>(static_cast<double>(value) / kThousand)};
    default: return std::nullopt;
  }
}

}  // namespace nacelle::camera
