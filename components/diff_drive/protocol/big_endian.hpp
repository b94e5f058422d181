// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

/// Big-endian reads and writes at any alignment. Preconditions: the bytes are there.
[[nodiscard]] inline std::uint16_t load_be16(const std::uint8_t* at) {
  return static_cast<std::uint16_t>((at[0] << 8) | at[1]);
}
[[nodiscard]] inline std::uint32_t load_be32(const std::uint8_t* at) {
  return (static_cast<std::uint32_t>(load_be16(at)) << 16) | load_be16(at + 2);
}
inline void store_be16(std::uint8_t* at, std::uint16_t value) {
  at[0] = static_cast<std::uint8_t>(value >> 8);
  at[1] = static_cast<std::uint8_t>(value);
}
inline void store_be32(std::uint8_t* at, std::uint32_t value) {
  store_be16(at, static_cast<std::uint16_t>(value >> 16));
  store_be16(at + 2, static_cast<std::uint16_t>(value));
}

/// CRC-16/XMODEM: polynomial 0x1021, most significant bit first, nothing reflected; `crc` continues an earlier one.
/// Source: RoboClaw and VESC both use it; the check value of "123456789" is 0x31C3.
[[nodiscard]] std::uint16_t crc16_xmodem(ByteView bytes, std::uint16_t crc = 0);

}  // namespace nacelle::diff_drive
