// SPDX-License-Identifier: Apache-2.0
// Any bytes, in any chopping: nothing crashes, every byte is accounted for, the events do not depend on the chopping. Of any pad, whatever its
// axes claim, every value stays within -1 to 1, every button is 0 or 1, and a velocity is finite.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "joy/model/pad_state.hpp"
#include "joy/model/twist_map.hpp"
#include "joy/protocol/input_event.hpp"

namespace {

using namespace nacelle::joy;

void require(bool holds) {
  if (!holds) std::abort();
}

/// A pad that the first events describe: a key event is a button, another one an axis.
PadInfo pad_of(const std::vector<InputEvent>& events) {
  PadInfo pad;
  for (std::size_t i = 0; i + 1 < std::min<std::size_t>(events.size(), 32); i += 2) {
    const InputEvent& event = events[i];
    if (event.type == input_layout::kKey) pad.buttons.set(event.code % pad_codes::kKeyCount);
    if (event.type == input_layout::kAbs)
      pad.axes[event.code % pad_codes::kAxisCount] = PadAxis{0, event.value, events[i + 1].value};
  }
  return pad;
}

void require_sane(const PadState& state) {
  for (const float axis : state.axes()) require(std::abs(axis) <= 1.0F);
  for (const int button : state.buttons()) require(button == 0 || button == 1);
  for (const bool needs_button : {false, true}) {
    const auto outcome = TwistMap{{.require_enable_button = needs_button}}.of(state.axes(), state.buttons());
    require(std::isfinite(outcome.twist.x) && std::isfinite(outcome.twist.yaw));
    require(outcome.enabled || outcome.twist == PadTwist{});
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const nacelle::ByteView bytes{data, size};
  std::vector<InputEvent> whole, chopped;
  InputEventDecoder at_once;
  for (nacelle::ByteView left = bytes; const auto event = at_once.next(left);) whole.push_back(*event);
  require(at_once.stats().bytes == size);
  require(size == 24 * at_once.stats().events + at_once.pending());

  InputEventDecoder in_parts;
  for (std::size_t at = 0; at < size;) {
    const std::size_t part = std::min<std::size_t>(size - at, 1 + data[at] % 29U);
    for (nacelle::ByteView left = bytes.subspan(at, part); const auto event = in_parts.next(left);)
      chopped.push_back(*event);
    at += part;
  }
  require(in_parts.stats() == at_once.stats());
  require(whole == chopped);
  in_parts.restart();
  require(size == 24 * in_parts.stats().events + in_parts.stats().dropped_bytes);

  for (const bool sticky : {false, true}) {
    PadState state{{.deadzone = 0.05, .sticky_buttons = sticky}};
    state.load(pad_of(whole));
    require_sane(state);
    for (const InputEvent& event : whole) state.take(event);
    require_sane(state);
  }
  return 0;
}
