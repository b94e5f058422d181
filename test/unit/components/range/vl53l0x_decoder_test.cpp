// SPDX-License-Identifier: Apache-2.0
#include "range/protocol/vl53l0x_decoder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace nacelle::range {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Layout and scales: ST, VL53L0X API, VL53L0X_GetRangingMeasurementData; the numbers are worked out by hand.
constexpr std::array<std::uint8_t, 12> kComplete{0x59, 0x00, 0x10, 0x80, 0x00, 0x00,
                                                 0x06, 0x40, 0x00, 0x20, 0x01, 0x2C};

TEST(Vl53l0xDecoder, decodes_a_result) {
  const Vl53l0xResult result = Vl53l0xDecoder::decode(kComplete);
  EXPECT_EQ(result.status, Vl53l0xStatus::Complete);
  EXPECT_EQ(result.distance_mm, 300);
  EXPECT_EQ(result.signal_rate, 1600) << "12.5 million a second";
  EXPECT_EQ(result.ambient_rate, 32) << "0.25 million a second";
  EXPECT_EQ(result.spads_in_256, 4224) << "16.5 cells";
}

TEST(Vl53l0xDecoder, takes_any_chopping_and_accounts_for_every_byte) {
  std::mt19937 random{20261128};
  Bytes bytes(5000);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  std::vector<Vl53l0xResult> whole, chopped;
  Vl53l0xDecoder one, other;
  one.feed(bytes, [&](const Vl53l0xResult& result) { whole.push_back(result); });
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + random() % 30);
    other.feed(ByteView{bytes}.subspan(at, part), [&](const Vl53l0xResult& result) { chopped.push_back(result); });
    at += part;
  }
  EXPECT_EQ(whole.size(), 416U);
  EXPECT_EQ(whole, chopped);
  EXPECT_EQ(other.pending(), 8U);
  other.restart();
  const auto& stats = other.stats();
  EXPECT_EQ(stats.bytes, 12 * stats.results + stats.dropped + other.pending());
  EXPECT_EQ(stats.dropped, 8U);
}

// REP 117. Codes: ST, VL53L0X API, VL53L0X_get_pal_range_status; what each means for a robot is in docs/hardware.md.
TEST(Vl53l0xRange, is_infinite_where_nothing_is_and_not_a_number_where_nothing_was_measured) {
  const auto range = [](int status, int mm) {
    return range_of({.status = static_cast<Vl53l0xStatus>(status), .distance_mm = static_cast<std::uint16_t>(mm)}, 0.03,
                    2.0);
  };
  EXPECT_DOUBLE_EQ(range(11, 1234), 1.234);
  EXPECT_DOUBLE_EQ(range(11, 30), 0.03);
  EXPECT_DOUBLE_EQ(range(11, 2000), 2.0);
  EXPECT_EQ(range(11, 2001), kInfinity);
  EXPECT_EQ(range(11, 8190), kInfinity);
  EXPECT_EQ(range(11, 29), -kInfinity);
  for (const int far : {4, 6, 9}) EXPECT_EQ(range(far, 8190), kInfinity) << far;
  EXPECT_EQ(range(10, 0), -kInfinity);
  for (const int invalid : {0, 1, 2, 3, 5, 7, 8, 12, 13, 14, 15})
    EXPECT_TRUE(std::isnan(range(invalid, 500))) << invalid;
}

}  // namespace
}  // namespace nacelle::range
