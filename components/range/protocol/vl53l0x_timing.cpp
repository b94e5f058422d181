// SPDX-License-Identifier: Apache-2.0
#include "range/protocol/vl53l0x_timing.hpp"

#include <algorithm>

namespace nacelle::range {
namespace {

// Around the steps, and around each of them.
constexpr Duration kStart = 1320us, kEnd = 960us, kCellSelection = 690us, kFirst = 660us, kSecond = 550us;

}  // namespace

std::uint16_t encode_periods(std::uint32_t periods) {
  if (periods == 0) return 0;
  std::uint32_t low = periods - 1, high = 0;
  for (; low > 0xFF; low >>= 1U) ++high;
  return static_cast<std::uint16_t>(high << 8U | low);
}

std::uint32_t decode_periods(std::uint16_t encoded) {
  // No device has more than 16 bits of periods.
  return ((encoded & 0xFFU) << std::min(encoded >> 8, 16)) + 1;
}

Duration macro_period(std::uint8_t laser_period) {
  // 2304 laser periods, each a number of clocks of 1655 ps.
  const std::int64_t clocks = (std::int64_t{laser_period} + 1) * 2;
  return Duration{(2304 * clocks * 1655 + 500) / 1000};
}

std::optional<std::uint16_t> second_timeout(Duration budget, const Vl53l0xSteps& steps) {
  const Duration first_period = macro_period(steps.first_laser_period);
  const std::uint32_t first = decode_periods(steps.first_timeout);
  const Duration selection = (steps.signal_check + 1) * first_period;
  const Duration before = kStart + kEnd + 2 * (selection + kCellSelection) + first * first_period + kFirst + kSecond;
  if (budget <= before) return std::nullopt;
  const Duration period = macro_period(steps.second_laser_period);
  const auto periods = static_cast<std::uint32_t>((budget - before + period / 2) / period);
  if (periods == 0 || periods + first > 0xFFFF) return std::nullopt;
  // The device counts the second measurement's time from the begin of the first one.
  return encode_periods(periods + first);
}

}  // namespace nacelle::range
