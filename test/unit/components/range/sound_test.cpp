// SPDX-License-Identifier: Apache-2.0
#include "range/model/sound.hpp"

#include <gtest/gtest.h>

namespace nacelle::range {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

// CRC Handbook of Chemistry and Physics, dry air: 331.4 m/s at 0 C, 343.2 at 20 C, 349.0 at 30 C.
TEST(Sound, has_the_speed_that_tables_have) {
  EXPECT_NEAR(speed_of_sound_mps(0.0), 331.4, 0.2);
  EXPECT_NEAR(speed_of_sound_mps(20.0), 343.2, 0.2);
  EXPECT_NEAR(speed_of_sound_mps(30.0), 349.0, 0.2);
}

// ElecFreaks, HC-SR04 User Guide: distance in cm is the pulse in us / 58.
TEST(Sound, agrees_with_the_makers_formula) {
  for (const int us : {580, 2900, 5800, 17400})
    EXPECT_NEAR(echo_range_m(std::chrono::microseconds{us}, 20.0, 0.02, 4.0), us / 58.0 / 100.0, 0.01 * us / 5800.0)
        << us;
}

TEST(Sound, is_infinite_outside_of_the_range) {
  EXPECT_EQ(echo_range_m(25ms, 20.0, 0.02, 4.0), kInf);
  EXPECT_EQ(echo_range_m(50us, 20.0, 0.02, 4.0), -kInf);
}

}  // namespace
}  // namespace nacelle::range
