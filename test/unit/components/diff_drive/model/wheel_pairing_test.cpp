// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/wheel_pairing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace nacelle::diff_drive {
namespace {

constexpr std::size_t kLeftWheel = 0, kRightWheel = 1;

TEST(WheelPairing, two_readings_that_come_together_are_a_pair) {
  WheelPairing pairing;
  EXPECT_FALSE(pairing.hear(kLeftWheel, {10ms}));
  EXPECT_TRUE(pairing.hear(kRightWheel, {11ms}));
  EXPECT_FALSE(pairing.hear(kRightWheel, {20ms}));
  EXPECT_TRUE(pairing.hear(kLeftWheel, {21ms}));
}

TEST(WheelPairing, a_wheel_alone_makes_no_pair) {
  WheelPairing pairing;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(pairing.hear(kLeftWheel, {i * 10ms}));
}

// By count, the right wheel's readings would be one behind from the loss on.
TEST(WheelPairing, a_lost_reading_costs_one_pair_and_shifts_nothing) {
  WheelPairing pairing;
  int pairs = 0;
  for (int i = 0; i < 20; ++i) {
    if (i != 10 && pairing.hear(kLeftWheel, {i * 10ms})) FAIL() << "paired with what came a period earlier, in " << i;
    if (pairing.hear(kRightWheel, {i * 10ms + 500us})) ++pairs;
  }
  EXPECT_EQ(pairs, 19);
}

TEST(WheelPairing, boards_at_any_phase_make_a_pair_a_period) {
  for (const Duration period : {2ms, 10ms, 20ms, 100ms}) {
    for (int phase = 0; phase < 10; ++phase) {
      WheelPairing pairing;
      int pairs = 0;
      for (int i = 0; i < 200; ++i) {
        pairs += static_cast<int>(pairing.hear(kLeftWheel, {i * period}));
        pairs += static_cast<int>(pairing.hear(kRightWheel, {i * period + phase * period / 10}));
      }
      EXPECT_GE(pairs, 180) << "period " << period.count() << " ns, phase " << phase << " tenths";
    }
  }
}

TEST(WheelPairing, readings_of_a_pair_are_never_further_apart_than_its_window_under_loss_and_jitter) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random{seed};
    WheelPairing pairing;
    MonotonicTime heard[2] = {};
    int pairs = 0;
    const int phase = static_cast<int>(random() % 10);
    for (int i = 0; i < 10000; ++i) {
      for (std::size_t wheel = 0; wheel < 2; ++wheel) {
        const MonotonicTime at{i * 10ms + (wheel == 1 ? phase * 1ms : 0ms) + Duration{random() % 300'000}};
        if (random() % 5 == 0) continue;  // lost
        const Duration window = pairing.window();
        heard[wheel] = at;
        if (!pairing.hear(wheel, at)) continue;
        ++pairs;
        ASSERT_LE(at - heard[1 - wheel], std::max(window, pairing.window())) << "seed " << seed << ", step " << i;
      }
    }
    // Both arrive in 64 of 100 periods.
    EXPECT_GT(pairs, 5000) << "seed " << seed << ", phase " << phase;
    EXPECT_LT(pairing.window(), 9ms);
  }
}

TEST(WheelPairing, frames_that_waited_and_are_read_at_once_are_paired_in_their_order) {
  WheelPairing pairing;
  for (int i = 0; i < 10; ++i) {
    static_cast<void>(pairing.hear(kLeftWheel, {i * 10ms}));
    EXPECT_TRUE(pairing.hear(kRightWheel, {i * 10ms}));
  }
  const Duration window = pairing.window();
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(pairing.hear(kLeftWheel, {200ms}));
    EXPECT_TRUE(pairing.hear(kRightWheel, {200ms}));
  }
  EXPECT_GE(pairing.window(), window) << "a burst is no period";
}

TEST(WheelPairing, a_restart_forgets) {
  WheelPairing pairing;
  EXPECT_FALSE(pairing.hear(kLeftWheel, {10ms}));
  pairing.restart();
  EXPECT_FALSE(pairing.hear(kRightWheel, {10ms}));
}

}  // namespace
}  // namespace nacelle::diff_drive
