// SPDX-License-Identifier: Apache-2.0
#include "range/protocol/vl53l0x_decoder.hpp"

#include <limits>

namespace nacelle::range {

Vl53l0xResult Vl53l0xDecoder::decode(const std::array<std::uint8_t, kRecordBytes>& record) {
  const auto word = [&](std::size_t at) {
    return static_cast<std::uint16_t>(unsigned{record[at]} << 8U | record[at + 1]);
  };
  return {.status = static_cast<Vl53l0xStatus>(record[0] >> 3U & 0x0FU),
          .distance_mm = word(10),
          .signal_rate = word(6),
          .ambient_rate = word(8),
          .spads_in_256 = word(2)};
}

double range_of(const Vl53l0xResult& result, double least_m, double most_m) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  switch (result.status) {
    case Vl53l0xStatus::Complete: {
      const double range_m = result.distance_mm * 1e-3;
      return range_m > most_m ? kInfinity : range_m < least_m ? -kInfinity : range_m;
    }
    case Vl53l0xStatus::NoTarget:
    case Vl53l0xStatus::Phase:
    case Vl53l0xStatus::PhaseConsistency: return kInfinity;
    case Vl53l0xStatus::BelowMinimum: return -kInfinity;
    default: return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace nacelle::range
