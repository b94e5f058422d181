// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace nacelle {

/// Borrowed bytes, valid for the length of a call.
using ByteView = std::span<const std::uint8_t>;
/// Borrowed writable bytes, valid for the length of a call.
using ByteSpan = std::span<std::uint8_t>;
using Bytes = std::vector<std::uint8_t>;

/// The bytes of a text, without a copy.
[[nodiscard]] inline ByteView as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}
/// The text that these bytes are, without a copy or a check.
[[nodiscard]] inline std::string_view as_text(ByteView bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Little-endian reads at any alignment. Preconditions: the view holds that many bytes.
[[nodiscard]] inline std::uint16_t load_le16(const std::uint8_t* at) {
  return static_cast<std::uint16_t>(at[0] | (at[1] << 8));
}
[[nodiscard]] inline std::int16_t load_le16s(const std::uint8_t* at) {
  return static_cast<std::int16_t>(load_le16(at));
}
inline void store_le16(std::uint8_t* at, std::uint16_t value) {
  at[0] = static_cast<std::uint8_t>(value);
  at[1] = static_cast<std::uint8_t>(value >> 8);
}

/// Lower-case hexadecimal, two digits a byte.
[[nodiscard]] std::string to_hex(ByteView bytes);
/// Reads hexadecimal of either case; white space between digits is skipped.
/// Errors: false on an odd number of digits or any other character; `out` then holds what came before it.
[[nodiscard]] bool from_hex(std::string_view text, Bytes& out);

}  // namespace nacelle
