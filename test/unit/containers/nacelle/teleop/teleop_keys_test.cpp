// SPDX-License-Identifier: Apache-2.0
#include "teleop/model/teleop_keys.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace nacelle::teleop {
namespace {

constexpr MonotonicTime kStart{10s};

TEST(TeleopKeys, the_keys_mean_what_teleop_twist_keyboard_means) {
  const TeleopOptions options;
  const double v = options.speed_mps, w = options.yaw_rate_rps;
  const struct {
    char key;
    TeleopCommand command;
  } cases[] = {{'i', {v, 0}},  {'o', {v, -w}}, {'j', {0, w}},   {'l', {0, -w}}, {'u', {v, w}},
               {',', {-v, 0}}, {'.', {-v, w}}, {'m', {-v, -w}}, {'k', {0, 0}},  {' ', {0, 0}}};
  for (const auto& expected : cases) {
    TeleopKeys keys{options};
    keys.press(expected.key, kStart);
    EXPECT_EQ(keys.command(), expected.command) << expected.key;
  }
}

TEST(TeleopKeys, a_released_key_ends_in_zeros_and_then_silence) {
  TeleopKeys keys{{}};
  keys.press('i', kStart);
  std::vector<TeleopCommand> sent;
  for (Duration t = 0ms; t < 3s; t += 10ms) {
    if (const auto command = keys.due(kStart + t)) sent.push_back(*command);
  }
  ASSERT_GT(sent.size(), 5U);
  EXPECT_GT(sent.front().speed_mps, 0);
  EXPECT_EQ(sent.back(), TeleopCommand{});
  EXPECT_FALSE(keys.due(kStart + 4s)) << "no key, no message: another sender may have the robot";
}

TEST(TeleopKeys, the_stop_follows_the_release_at_once) {
  const TeleopOptions options;
  TeleopKeys keys{options};
  keys.press('i', kStart);
  const MonotonicTime release = kStart + options.release_after;
  EXPECT_TRUE(keys.due(release - 1ms));
  const auto stop = keys.due(release);
  ASSERT_TRUE(stop);
  EXPECT_EQ(*stop, TeleopCommand{});
}

TEST(TeleopKeys, a_key_that_repeats_stays_held) {
  TeleopKeys keys{{}};
  for (Duration t = 0ms; t < 5s; t += 30ms) {
    // A terminal waits half a second before the first repeat.
    if (t == 0ms || t > 500ms) keys.press('i', kStart + t);
    const auto command = keys.due(kStart + t);
    if (command) { EXPECT_GT(command->speed_mps, 0) << to_seconds(t); }
  }
}

TEST(TeleopKeys, speeds_change_by_ten_percent_up_to_their_limits) {
  TeleopKeys keys{{}};
  const double before = keys.speed_mps(), turn = keys.yaw_rate_rps();
  EXPECT_EQ(keys.press('w', kStart), KeyEffect::Faster);
  EXPECT_DOUBLE_EQ(keys.speed_mps(), before * 1.1);
  EXPECT_DOUBLE_EQ(keys.yaw_rate_rps(), turn);
  for (int i = 0; i < 100; ++i) keys.press('q', kStart);
  EXPECT_DOUBLE_EQ(keys.speed_mps(), TeleopOptions{}.top_speed_mps);
  EXPECT_DOUBLE_EQ(keys.yaw_rate_rps(), TeleopOptions{}.top_yaw_rate_rps);
}

TEST(TeleopKeys, keys_for_sliding_and_lifting_stop_the_robot) {
  for (const char key : {'t', 'b', 'O', 'I', 'J', 'L', 'U', '<', '>', 'M'}) {
    TeleopKeys keys{{}};
    keys.press('i', kStart);
    EXPECT_EQ(keys.press(key, kStart), KeyEffect::Holonomic) << key;
    EXPECT_EQ(keys.command(), TeleopCommand{});
  }
}

TEST(TeleopKeys, no_sequence_of_keys_exceeds_the_limits) {
  const unsigned seed = 3;
  std::mt19937 random{seed};
  TeleopKeys keys{{}};
  MonotonicTime now = kStart;
  for (int i = 0; i < 20000; ++i, now += 7ms) {
    keys.press(static_cast<char>(random() % 128), now);
    ASSERT_LE(std::abs(keys.command().speed_mps), TeleopOptions{}.top_speed_mps) << "seed " << seed << ", key " << i;
    ASSERT_LE(std::abs(keys.command().yaw_rate_rps), TeleopOptions{}.top_yaw_rate_rps);
  }
}

}  // namespace
}  // namespace nacelle::teleop
