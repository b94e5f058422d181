// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/wt901_device.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::simulation {
namespace {

std::int16_t counts(double value, double full_scale) {
  return static_cast<std::int16_t>(std::clamp(std::round(value / full_scale * 32768.0), -32768.0, 32767.0));
}

}  // namespace

std::array<std::uint8_t, 11> print_wt901(std::uint8_t type, const Wt901Reading& reading) {
  std::array<std::int16_t, 4> values{};
  values[3] = counts(reading.temperature_c * 100.0, 32768.0);
  for (std::size_t i = 0; i < 3; ++i) {
    if (type == 0x51) values[i] = counts(reading.acceleration_g[i], 16.0);
    if (type == 0x52) values[i] = counts(reading.angular_velocity_dps[i], 2000.0);
    if (type == 0x53) values[i] = counts(reading.angles_deg[i], 180.0);
    if (type == 0x54) values[i] = counts(reading.magnetic_field_counts[i], 32768.0);
  }
  if (type == 0x59) {
    for (std::size_t i = 0; i < 4; ++i) values[i] = counts(reading.quaternion[i], 1.0);
  }
  std::array<std::uint8_t, 11> bytes{0x55, type};
  for (std::size_t i = 0; i < 4; ++i) store_le16(bytes.data() + 2 + 2 * i, static_cast<std::uint16_t>(values[i]));
  unsigned sum = 0;
  for (std::size_t i = 0; i < 10; ++i) sum += bytes[i];
  bytes[10] = static_cast<std::uint8_t>(sum);
  return bytes;
}

void Wt901Registers::command(std::uint8_t reg, std::uint16_t value, double now_s) {
  if (reg == 0x69 && value == 0xB588) {
    unlocked_until_s_ = now_s + 10.0;
    ++stats_.commands;
    return;
  }
  if (now_s > unlocked_until_s_) {
    ++stats_.locked;
    return;
  }
  ++stats_.commands;
  if (reg == 0x02) mask_ = value;
  if (reg == 0x03) {
    constexpr std::array kRatesHz{0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 125.0, 200.0};
    if (value >= 1 && value <= kRatesHz.size()) rate_hz_ = kRatesHz[value - 1U];
    if (value == 0x0C || value == 0x0D) rate_hz_ = 0.0;
  }
}

void Wt901Registers::feed(ByteView bytes, double now_s) {
  for (const std::uint8_t byte : bytes) {
    pending_[length_++] = byte;
    while (length_ > 0 && (pending_[0] != 0xFF || (length_ > 1 && pending_[1] != 0xAA))) {
      std::copy(pending_.begin() + 1, pending_.begin() + static_cast<std::ptrdiff_t>(length_), pending_.begin());
      --length_;
      ++stats_.skipped_bytes;
    }
    if (length_ < pending_.size()) continue;
    command(pending_[2], static_cast<std::uint16_t>(pending_[3] | (pending_[4] << 8)), now_s);
    length_ = 0;
  }
}

}  // namespace nacelle::simulation
