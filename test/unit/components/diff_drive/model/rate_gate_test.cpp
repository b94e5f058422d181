// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/rate_gate.hpp"

#include <gtest/gtest.h>

#include <random>

namespace nacelle::diff_drive {
namespace {

int passed(Duration source_period, Duration jitter, int events, Duration gate_period) {
  std::mt19937 random{5};
  RateGate gate{gate_period};
  int count = 0;
  for (int i = 0; i < events; ++i) {
    const auto shift =
        jitter.count() == 0 ? Duration{} : Duration{static_cast<std::int64_t>(random() % jitter.count())};
    if (gate.passes({100s + i * source_period + shift})) ++count;
  }
  return count;
}

TEST(RateGate, lets_a_source_of_the_same_rate_pass_whole_in_spite_of_jitter) {
  EXPECT_EQ(passed(20ms, 0ms, 1000, 20ms), 1000);
  EXPECT_GE(passed(20ms, 5ms, 1000, 20ms), 998);
}
TEST(RateGate, thins_a_faster_source_to_the_rate) {
  EXPECT_NEAR(passed(10ms, 2ms, 1000, 20ms), 500, 3);
  EXPECT_NEAR(passed(7ms, 0ms, 1000, 20ms), 350, 3);
}
TEST(RateGate, lets_a_slower_source_pass_whole) { EXPECT_EQ(passed(33ms, 5ms, 1000, 20ms), 1000); }
TEST(RateGate, saves_up_no_burst_after_a_silence) {
  RateGate gate{20ms};
  ASSERT_TRUE(gate.passes({1s}));
  int burst = 0;
  for (int i = 0; i < 50; ++i) burst += gate.passes({10s + i * 1us}) ? 1 : 0;
  EXPECT_LE(burst, 3);
}

}  // namespace
}  // namespace nacelle::diff_drive
