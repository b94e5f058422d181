// SPDX-License-Identifier: Apache-2.0
#include "joy/protocol/input_event.hpp"

namespace nacelle::joy {
namespace {

std::uint64_t load_le(const std::uint8_t* at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t i = bytes; i > 0; --i) value = (value << 8U) | at[i - 1];
  return value;
}

}  // namespace

InputEvent read_input_event(const std::uint8_t* at) {
  using namespace input_layout;
  // Unsigned, so that times that no clock has wrap instead of being undefined.
  const std::uint64_t ns = load_le(at + kSeconds, 8) * 1'000'000'000U + load_le(at + kMicroseconds, 8) * 1000U;
  return {MonotonicTime{Duration{static_cast<std::int64_t>(ns)}}, load_le16(at + kType), load_le16(at + kCode),
          static_cast<std::int32_t>(load_le(at + kValue, 4))};
}

}  // namespace nacelle::joy
