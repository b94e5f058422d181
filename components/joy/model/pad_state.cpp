// SPDX-License-Identifier: Apache-2.0
#include "joy/model/pad_state.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::joy {

using namespace pad_codes;

namespace {

bool is_hat(std::size_t code) { return code >= kFirstHat && code <= kLastHat; }

}  // namespace

bool is_gamepad(const PadInfo& pad) {
  bool has_button = false;
  for (std::size_t code = kFirstJoystickButton; code < kFirstDigitizerButton; ++code) has_button |= pad.buttons[code];
  const auto has_both = [&](std::size_t first) { return pad.axes[first] && pad.axes[first + 1]; };
  return has_button && (has_both(kAxisX) || has_both(kFirstHat));
}

void PadState::load(const PadInfo& pad) {
  button_of_.fill(kNone);
  axis_of_.fill(kNone);
  const std::vector<std::int32_t> before = buttons_;
  buttons_.clear();
  axes_.clear();
  const auto add_button = [&](std::size_t code) {
    if (!pad.buttons[code]) return;
    button_of_[code] = static_cast<std::int16_t>(buttons_.size());
    buttons_.push_back(pad.pressed[code] && !settings_.sticky_buttons ? 1 : 0);
  };
  for (std::size_t code = kFirstJoystickButton; code < kKeyCount; ++code) add_button(code);
  for (std::size_t code = 0; code < kFirstJoystickButton; ++code) add_button(code);
  if (settings_.sticky_buttons && before.size() == buttons_.size()) buttons_ = before;

  const auto add_axis = [&](std::size_t code) {
    axis_of_[code] = static_cast<std::int16_t>(axes_.size());
    ranges_[code] = pad.axes[code].value_or(PadAxis{});
    axes_.push_back(pad.axes[code] ? position(ranges_[code].value, ranges_[code]) : 0.0F);
  };
  for (std::size_t code = 0; code < kAxisCount; ++code) {
    if (pad.axes[code] && !is_hat(code)) add_axis(code);
  }
  for (std::size_t code = kFirstHat; code < kLastHat; code += 2) {
    if (!pad.axes[code] && !pad.axes[code + 1]) continue;
    add_axis(code);
    add_axis(code + 1);
  }
}

PadState::Change PadState::take(const InputEvent& event) {
  if (event.type == input_layout::kKey && event.code < kKeyCount && button_of_[event.code] != kNone &&
      event.value <= 1) {
    std::int32_t& button = buttons_[static_cast<std::size_t>(button_of_[event.code])];
    const std::int32_t wanted = !settings_.sticky_buttons ? (event.value == 0 ? 0 : 1)
                                : event.value == 0        ? button
                                                          : 1 - button;
    if (button == wanted) return Change::None;
    button = wanted;
    return Change::Button;
  }
  if (event.type == input_layout::kAbs && event.code < kAxisCount && axis_of_[event.code] != kNone) {
    float& axis = axes_[static_cast<std::size_t>(axis_of_[event.code])];
    const float wanted = position(event.value, ranges_[event.code]);
    if (axis == wanted) return Change::None;
    axis = wanted;
    // A hat is a set of buttons.
    return is_hat(event.code) ? Change::Button : Change::Axis;
  }
  return Change::None;
}

float PadState::position(std::int32_t value, const PadAxis& range) const {
  const double least = range.minimum, most = range.maximum;
  if (most <= least) return 0.0F;
  const double share = std::clamp((static_cast<double>(value) - least) / (most - least), 0.0, 1.0) * 2.0 - 1.0;
  const double beyond = std::abs(share) - settings_.deadzone;
  if (beyond <= 0.0) return 0.0F;
  return static_cast<float>(-std::copysign(beyond / (1.0 - settings_.deadzone), share));
}

}  // namespace nacelle::joy
