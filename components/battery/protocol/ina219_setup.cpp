// SPDX-License-Identifier: Apache-2.0
#include "battery/protocol/ina219_setup.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::battery {
namespace {

// Bits of the configuration register.
constexpr unsigned kBusUpTo32V = 1U << 13U, kShuntRangeAt = 11, kBusSamplesAt = 7, kShuntSamplesAt = 3;
constexpr unsigned kBothContinuously = 0b111;
constexpr double kNarrowestShunt_v = 0.04;
constexpr unsigned kRanges = 4;
// One sample of 12 bits, then twice as many with each code.
constexpr unsigned kOneSample = 0b1000, kSampleCodes = 8;
constexpr Duration kSample = 532us;
constexpr unsigned kHighestCalibration = 0xFFFE;  // bit 0 cannot be set

}  // namespace

std::optional<Ina219Setup> ina219_setup(double shunt_ohms, double max_current_a, Duration period) {
  const double highest_v = shunt_ohms * max_current_a;
  // A product a rounding above the range is within it.
  if (!(highest_v <= kIna219WidestShunt_v * (1.0 + 1e-9))) return std::nullopt;
  unsigned range = 0;
  while (range + 1 < kRanges && highest_v > kNarrowestShunt_v * (1U << range) * (1.0 + 1e-9)) ++range;
  unsigned doublings = 0;
  while (doublings + 1 < kSampleCodes && 4 * kSample * (2LL << doublings) <= period) ++doublings;
  const unsigned samples = kOneSample + doublings;

  Ina219Setup setup;
  setup.config = static_cast<std::uint16_t>(kBusUpTo32V | (range << kShuntRangeAt) | (samples << kBusSamplesAt) |
                                            (samples << kShuntSamplesAt) | kBothContinuously);
  const double calibration = std::floor(0.04096 / (max_current_a / 32768.0 * shunt_ohms) + 1e-6);
  setup.calibration =
      static_cast<std::uint16_t>(static_cast<unsigned>(std::min(calibration, 65534.0)) & kHighestCalibration);
  setup.amperes_per_count = 0.04096 / (setup.calibration * shunt_ohms);
  return setup;
}

}  // namespace nacelle::battery
