// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/big_endian.hpp"

#include <array>

namespace nacelle::diff_drive {
namespace {

constexpr std::array<std::uint16_t, 256> crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U);
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}
constexpr auto kTable = crc_table();

}  // namespace

std::uint16_t crc16_xmodem(ByteView bytes, std::uint16_t crc) {
  for (const std::uint8_t byte : bytes)
    crc = static_cast<std::uint16_t>((crc << 8) ^ kTable[static_cast<std::uint8_t>((crc >> 8) ^ byte)]);
  return crc;
}

}  // namespace nacelle::diff_drive
