// SPDX-License-Identifier: Apache-2.0
#include "range/protocol/vl53l0x_timing.hpp"

#include <gtest/gtest.h>

namespace nacelle::range {
namespace {

// Worked examples of the comment in ST's VL53L0X_encode_timeout: (low byte * 2^high byte) + 1.
TEST(Vl53l0xTiming, counts_periods_as_a_mantissa_and_an_exponent) {
  EXPECT_EQ(decode_periods(0x0000), 1U);
  EXPECT_EQ(decode_periods(0x0096), 151U);
  EXPECT_EQ(decode_periods(0x01FE), 509U);
  EXPECT_EQ(encode_periods(0), 0x0000);
  EXPECT_EQ(encode_periods(151), 0x0096);
  EXPECT_EQ(encode_periods(509), 0x01FE);
}

TEST(Vl53l0xTiming, encoding_loses_less_than_a_part_in_128_and_never_adds) {
  for (std::uint32_t periods = 1; periods <= 0xFFFF; ++periods) {
    const std::uint32_t back = decode_periods(encode_periods(periods));
    ASSERT_LE(back, periods);
    ASSERT_LE(periods - back, periods / 128) << periods;
  }
}

TEST(Vl53l0xTiming, decodes_every_register) {
  for (std::uint32_t value = 0; value <= 0xFFFF; ++value)
    ASSERT_GE(decode_periods(static_cast<std::uint16_t>(value)), 1U);
}

// 2304 * 14 * 1655 ps and 2304 * 10 * 1655 ps.
TEST(Vl53l0xTiming, knows_the_macro_period_of_the_laser) {
  EXPECT_EQ(macro_period(6), 53384ns);
  EXPECT_EQ(macro_period(4), 38131ns);
}

/// With the maker's settings.
constexpr Vl53l0xSteps kTuned{
    .signal_check = 0x25, .first_laser_period = 6, .first_timeout = 0x0096, .second_laser_period = 4};

TEST(Vl53l0xTiming, gives_the_second_measurement_what_the_others_leave) {
  // 33000 us - (1320 + 960 + 2 * (38 * 53.384 + 690) + 151 * 53.384 + 660 + 550) us are 420 periods of 38.131 us; 151 before them.
  EXPECT_EQ(second_timeout(33ms, kTuned), encode_periods(571));
  EXPECT_GT(decode_periods(*second_timeout(200ms, kTuned)), 4000U);
}

TEST(Vl53l0xTiming, refuses_what_is_too_short_or_too_long) {
  EXPECT_TRUE(second_timeout(20ms, kTuned));
  EXPECT_FALSE(second_timeout(16ms, kTuned));
  EXPECT_FALSE(second_timeout(0ms, kTuned));
  EXPECT_FALSE(second_timeout(10s, kTuned));
}

}  // namespace
}  // namespace nacelle::range
