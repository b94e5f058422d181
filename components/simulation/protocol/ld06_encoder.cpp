// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/ld06_encoder.hpp"

namespace nacelle::simulation {

std::array<std::uint8_t, 47> print_ld06(const Ld06Packet& packet) {
  std::array<std::uint8_t, 47> bytes{};
  std::size_t length = 0;
  const auto put8 = [&](unsigned value) { bytes[length++] = static_cast<std::uint8_t>(value); };
  const auto put16 = [&](unsigned value) {
    put8(value & 0xFFU);
    put8(value >> 8U);
  };
  put8(0x54);
  put8(0x2C);
  put16(packet.speed_dps);
  put16(packet.start_cdeg);
  for (const auto& point : packet.points) {
    put16(point.range_mm);
    put8(point.intensity);
  }
  put16(packet.end_cdeg);
  put16(packet.time_ms);
  unsigned crc = 0;
  for (std::size_t i = 0; i < length; ++i) {
    crc ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) crc = ((crc << 1U) ^ ((crc & 0x80U) != 0 ? 0x4DU : 0U)) & 0xFFU;
  }
  put8(crc);
  return bytes;
}

}  // namespace nacelle::simulation
