// SPDX-License-Identifier: Apache-2.0
#include "joy/port/scripted_pad.hpp"

#include <linux/input.h>

#include <cstring>

namespace nacelle::joy {

Bytes ScriptedPad::event(MonotonicTime at, std::uint16_t type, std::uint16_t code, std::int32_t value) {
  input_event event{};
  event.input_event_sec = at.nanoseconds() / 1'000'000'000;
  event.input_event_usec = at.nanoseconds() / 1000 % 1'000'000;
  event.type = type;
  event.code = code;
  event.value = value;
  Bytes bytes(sizeof event);
  std::memcpy(bytes.data(), &event, sizeof event);
  return bytes;
}

Result<PadInfo, io::StreamFault> ScriptedPad::inspect() {
  if (line_.is_away()) return err(io::StreamFault::NotFound);
  return *info_.lock();
}

}  // namespace nacelle::joy
