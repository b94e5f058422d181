// SPDX-License-Identifier: Apache-2.0
#include "joy/model/twist_map.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace nacelle::joy {
namespace {

TwistMap::Settings settings() {
  TwistMap::Settings map;
  map.enable_button = 0;
  map.turbo_button = 1;
  map.x = {1, 0.5, 2.0};
  map.y = {3, 0.25, 0.5};
  map.yaw = {0, 1.5, 3.0};
  return map;
}
constexpr std::array kAxes{0.5F, -1.0F, 0.0F, 1.0F};

TEST(TwistMap, is_zero_until_a_button_is_held) {
  const auto outcome = TwistMap{settings()}.of(kAxes, std::array{0, 0});
  EXPECT_FALSE(outcome.enabled);
  EXPECT_EQ(outcome.twist, PadTwist{});
}

TEST(TwistMap, scales_the_axes) {
  const auto outcome = TwistMap{settings()}.of(kAxes, std::array{1, 0});
  EXPECT_TRUE(outcome.enabled);
  EXPECT_EQ(outcome.twist, (PadTwist{.x = -0.5, .y = 0.25, .yaw = 0.75}));
}

TEST(TwistMap, the_turbo_button_counts_alone_and_first) {
  const TwistMap map{settings()};
  EXPECT_EQ(map.of(kAxes, std::array{0, 1}).twist, (PadTwist{.x = -2.0, .y = 0.5, .yaw = 1.5}));
  EXPECT_EQ(map.of(kAxes, std::array{1, 1}).twist.x, -2.0);
}

TEST(TwistMap, may_do_without_an_enable_button) {
  auto without = settings();
  without.require_enable_button = false;
  EXPECT_TRUE(TwistMap{without}.of(kAxes, std::array{0, 0}).enabled);
  EXPECT_TRUE(TwistMap{without}.of(kAxes, {}).enabled);
}

TEST(TwistMap, inverted_reverse_turns_the_other_way_round_backwards) {
  auto inverted = settings();
  inverted.inverted_reverse = true;
  EXPECT_EQ(TwistMap{inverted}.of(kAxes, std::array{1, 0}).twist.yaw, -0.75);
  EXPECT_EQ(TwistMap{inverted}.of(std::array{0.5F, 1.0F}, std::array{1, 0}).twist.yaw, 0.75);
}

TEST(TwistMap, indices_that_a_message_does_not_have_are_at_rest) {
  const TwistMap map{settings()};
  EXPECT_FALSE(map.of(kAxes, {}).enabled);
  EXPECT_EQ(map.of({}, std::array{1, 0}).twist, PadTwist{});
  auto none = settings();
  none.enable_button = none.turbo_button = -1;
  EXPECT_FALSE(TwistMap{none}.of(kAxes, std::array{1, 1}).enabled);
  none.enable_button = std::numeric_limits<std::int64_t>::max();
  EXPECT_FALSE(TwistMap{none}.of(kAxes, std::array{1, 1}).enabled);
}

TEST(TwistMap, an_axis_that_is_no_number_is_at_rest) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(TwistMap{settings()}.of(std::array{kNaN, kInf, 0.0F, -kInf}, std::array{1, 0}).twist, PadTwist{});
}

// ros2/teleop_twist_joy: the defaults fit a pad with the right stick on axes 2 and 5 and the right shoulder on button 5.
TEST(TwistMap, has_the_defaults_of_ros) {
  const TwistMap map{{}};
  const std::array axes{0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 1.0F};
  EXPECT_EQ(map.of(axes, std::array{0, 0, 0, 0, 0, 1}).twist, (PadTwist{.x = 0.5, .yaw = 0.5}));
  EXPECT_FALSE(map.of(axes, std::array{1, 1, 1, 1, 1, 0}).enabled);
}

}  // namespace
}  // namespace nacelle::joy
