// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/ydlidar_device.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace nacelle::simulation {

Bytes print_ydlidar(std::span<const YdlidarSample> samples, bool starts_turn, double turn_hz, bool with_intensities) {
  const auto angle = [](double deg) {
    return static_cast<unsigned>(std::lround(std::fmod(deg + 360.0, 360.0) * 64.0) % (360 * 64)) << 1U | 1U;
  };
  const unsigned kind = (starts_turn ? 1U : 0U) | static_cast<unsigned>(std::lround(turn_hz * 10.0)) << 1U;
  const auto count = static_cast<unsigned>(samples.size());
  const unsigned first = angle(samples.front().rotor_deg), last = angle(samples.back().rotor_deg);
  std::vector<unsigned> words{0x55AA, first};
  Bytes body;
  const auto put = [&](unsigned word) {
    words.push_back(word);
    body.push_back(static_cast<std::uint8_t>(word));
    body.push_back(static_cast<std::uint8_t>(word >> 8U));
  };
  for (const YdlidarSample& sample : samples) {
    if (with_intensities) {
      words.push_back(sample.intensity & 0xFFU);
      body.push_back(static_cast<std::uint8_t>(sample.intensity));
      put(static_cast<unsigned>(std::lround(std::min(sample.range_mm, 16383.0))) << 2U | (sample.intensity >> 8U & 3U));
    } else {
      put(static_cast<unsigned>(std::lround(std::min(sample.range_mm, 16383.0) * 4.0)));
    }
  }
  words.push_back(count << 8U | kind);
  words.push_back(last);
  unsigned check = 0;
  for (const unsigned word : words) check ^= word;
  Bytes packet{0xAA, 0x55, static_cast<std::uint8_t>(kind), static_cast<std::uint8_t>(count)};
  for (const unsigned word : {first, last, check}) {
    packet.push_back(static_cast<std::uint8_t>(word));
    packet.push_back(static_cast<std::uint8_t>(word >> 8U));
  }
  packet.insert(packet.end(), body.begin(), body.end());
  return packet;
}

double ydlidar_offset_deg(double range_mm) {
  if (range_mm <= 0.0) return 0.0;
  return std::atan2(21.8 * (range_mm - 155.3), 155.3 * range_mm) * 180.0 / std::numbers::pi;
}

}  // namespace nacelle::simulation
