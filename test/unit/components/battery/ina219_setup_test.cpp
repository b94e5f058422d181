// SPDX-License-Identifier: Apache-2.0
// Expected words by hand from the data sheet's tables.
#include "battery/protocol/ina219_setup.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace nacelle::battery {
namespace {

TEST(Ina219Setup, the_usual_board_measures_up_to_3_2_amperes) {
  const auto setup = ina219_setup(0.1, 3.2, 1s);
  ASSERT_TRUE(setup);
  // 32 V, 320 mV, 128 samples of both, continuous.
  EXPECT_EQ(setup->config, 0x3FFF);
  EXPECT_EQ(setup->calibration, 4194);
  EXPECT_NEAR(setup->amperes_per_count, 3.2 / 32768, 2e-8);
}

TEST(Ina219Setup, matches_the_data_sheets_example) {
  // Design example of the data sheet: 15 A over 2 mOhm are 30 mV; it rounds the step of the current up to 1 mA and so calibrates with 5000 hex.
  const auto setup = ina219_setup(0.002, 32.768, 1s);
  ASSERT_TRUE(setup);
  EXPECT_EQ(setup->calibration, 0x5000);
  EXPECT_NEAR(setup->amperes_per_count, 0.001, 1e-12);
  EXPECT_EQ(ina219_setup(0.002, 15.0, 1s)->config & 0x1800, 0x0000) << "40 mV";
}

TEST(Ina219Setup, the_narrowest_range_that_holds_the_highest_current_is_chosen) {
  const auto range_of = [](double max_current_a) { return ina219_setup(0.1, max_current_a, 1s)->config >> 11 & 3; };
  EXPECT_EQ(range_of(0.1), 0);
  EXPECT_EQ(range_of(0.4), 0);
  EXPECT_EQ(range_of(0.41), 1);
  EXPECT_EQ(range_of(0.8), 1);
  EXPECT_EQ(range_of(1.6), 2);
  EXPECT_EQ(range_of(1.7), 3);
  EXPECT_EQ(range_of(3.2), 3);
}

TEST(Ina219Setup, a_current_beyond_the_widest_range_is_refused) {
  EXPECT_FALSE(ina219_setup(0.1, 3.21, 1s));
  EXPECT_FALSE(ina219_setup(0.01, 33.0, 1s));
  EXPECT_TRUE(ina219_setup(0.01, 32.0, 1s));
}

TEST(Ina219Setup, a_low_current_takes_the_finest_steps_that_the_chip_has) {
  const auto setup = ina219_setup(0.1, 0.01, 1s);
  ASSERT_TRUE(setup);
  EXPECT_EQ(setup->calibration, 0xFFFE);
  EXPECT_GT(32767 * setup->amperes_per_count, 0.01);
}

TEST(Ina219Setup, both_conversions_fit_twice_into_a_period) {
  const std::pair<Duration, int> table[] = {{1s, 128}, {300ms, 128}, {200ms, 64}, {100ms, 32},
                                            {20ms, 8}, {10ms, 4},    {5ms, 2},    {2ms, 1}};
  for (const auto& [period, samples] : table) {
    const auto setup = ina219_setup(0.1, 1.0, period);
    ASSERT_TRUE(setup);
    EXPECT_EQ(1 << (setup->config >> 7 & 7), samples) << to_seconds(period);
    EXPECT_EQ(setup->config >> 7 & 15, setup->config >> 3 & 15) << to_seconds(period);
    EXPECT_NE(setup->config & 0x0400, 0) << "a mean, not a resolution";
  }
}

}  // namespace
}  // namespace nacelle::battery
