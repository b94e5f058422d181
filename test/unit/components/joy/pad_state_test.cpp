// SPDX-License-Identifier: Apache-2.0
#include "joy/model/pad_state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "pads.hpp"

namespace nacelle::joy {
namespace {

using Change = PadState::Change;

InputEvent key(unsigned code, int value) { return {{}, input_layout::kKey, static_cast<std::uint16_t>(code), value}; }
InputEvent axis(unsigned code, int value) { return {{}, input_layout::kAbs, static_cast<std::uint16_t>(code), value}; }

PadState loaded(const PadState::Settings& settings = {.deadzone = 0.0}, const PadInfo& pad = xbox_pad()) {
  PadState state{settings};
  state.load(pad);
  return state;
}

TEST(PadState, orders_buttons_and_axes_as_ros_does) {
  PadState state = loaded();
  ASSERT_EQ(state.buttons().size(), 11U);
  ASSERT_EQ(state.axes().size(), 8U);
  state.take(key(BTN_A, 1));
  state.take(key(BTN_TR, 1));
  EXPECT_EQ(state.buttons()[kXboxA], 1);
  EXPECT_EQ(state.buttons()[kXboxRightShoulder], 1);
  state.take(axis(ABS_RX, -32768));
  EXPECT_EQ(state.axes()[kXboxRightX], 1.0F);
  state.take(axis(ABS_HAT0Y, -1));
  EXPECT_EQ(state.axes()[kXboxHatY], 1.0F);
}

TEST(PadState, puts_keys_below_the_joystick_buttons_last_and_hats_behind_the_axes) {
  PadInfo pad = xbox_pad();
  pad.buttons.set(KEY_RECORD);
  pad.axes[ABS_TILT_X] = PadAxis{0, 0, 100};
  PadState state = loaded({.deadzone = 0.0}, pad);
  state.take(key(KEY_RECORD, 1));
  EXPECT_EQ(state.buttons().back(), 1);
  state.take(axis(ABS_HAT0X, 1));
  EXPECT_EQ(state.axes()[7], -1.0F);
}

// ROS 2's joy: left and up are positive, and a trigger at rest is 1.
TEST(PadState, has_the_signs_of_ros) {
  PadState state = loaded();
  EXPECT_EQ(state.take(axis(ABS_X, -32768)), Change::Axis);
  EXPECT_EQ(state.axes()[kXboxLeftX], 1.0F) << "left";
  state.take(axis(ABS_Y, 32767));
  EXPECT_EQ(state.axes()[kXboxLeftY], -1.0F) << "down";
  EXPECT_EQ(state.axes()[kXboxLeftTrigger], 1.0F);
  state.take(axis(ABS_Z, 255));
  EXPECT_EQ(state.axes()[kXboxLeftTrigger], -1.0F);
}

TEST(PadState, grows_steadily_from_the_edge_of_the_dead_zone) {
  PadState state = loaded({.deadzone = 0.25});
  float before = 2.0F;
  for (int value = -32768; value <= 32767; value += 257) {
    state.take(axis(ABS_X, value));
    const float now = state.axes()[kXboxLeftX];
    EXPECT_LE(now, before) << value;
    if (value > -32768) { EXPECT_LT(before - now, 0.02F) << "a jump at " << value; }
    if (std::abs(value) < 8192 - 257) { EXPECT_EQ(now, 0.0F) << value; }
    before = now;
  }
  EXPECT_EQ(before, -1.0F);
}

TEST(PadState, tells_what_changed) {
  PadState state = loaded({.deadzone = 0.05});
  EXPECT_EQ(state.take(key(BTN_A, 1)), Change::Button);
  EXPECT_EQ(state.take(key(BTN_A, 1)), Change::None);
  EXPECT_EQ(state.take(key(BTN_A, 2)), Change::None) << "repeated by the kernel";
  EXPECT_EQ(state.take(axis(ABS_X, 100)), Change::None) << "within the dead zone";
  EXPECT_EQ(state.take(axis(ABS_X, 10000)), Change::Axis);
  EXPECT_EQ(state.take(axis(ABS_HAT0X, 1)), Change::Button) << "a hat is made of buttons";
  EXPECT_EQ(state.take(key(BTN_DEAD, 1)), Change::None) << "it has none";
  EXPECT_EQ(state.take({{}, 2, REL_X, 5}), Change::None);
}

TEST(PadState, sticky_buttons_switch_over_and_survive_lost_events) {
  PadState state = loaded({.deadzone = 0.05, .sticky_buttons = true});
  EXPECT_EQ(state.take(key(BTN_A, 1)), Change::Button);
  EXPECT_EQ(state.take(key(BTN_A, 0)), Change::None);
  EXPECT_EQ(state.buttons()[kXboxA], 1);
  state.load(xbox_pad());
  EXPECT_EQ(state.buttons()[kXboxA], 1);
  state.take(key(BTN_A, 1));
  EXPECT_EQ(state.buttons()[kXboxA], 0);
}

TEST(PadState, load_takes_over_how_the_pad_stands) {
  PadInfo pad = xbox_pad();
  pad.pressed.set(BTN_A);
  pad.axes[ABS_Y]->value = -32768;
  const PadState state = loaded({.deadzone = 0.05}, pad);
  EXPECT_EQ(state.buttons()[kXboxA], 1);
  EXPECT_EQ(state.axes()[kXboxLeftY], 1.0F);
}

TEST(PadState, holds_any_value_of_any_range_within_one) {
  constexpr unsigned kSeed = 9;
  std::mt19937 random{kSeed};
  for (int round = 0; round < 2000; ++round) {
    PadInfo pad = xbox_pad();
    pad.axes[ABS_X] = PadAxis{static_cast<std::int32_t>(random()), static_cast<std::int32_t>(random()),
                              static_cast<std::int32_t>(random())};
    PadState state = loaded({.deadzone = 0.99}, pad);
    state.take(axis(ABS_X, static_cast<std::int32_t>(random())));
    EXPECT_LE(std::abs(state.axes()[kXboxLeftX]), 1.0F) << "seed " << kSeed << ", round " << round;
  }
}

TEST(IsGamepad, knows_pads_and_sticks_from_other_things_with_keys) {
  EXPECT_TRUE(is_gamepad(xbox_pad()));
  PadInfo stick;
  stick.buttons.set(BTN_TRIGGER);
  stick.axes[ABS_X] = stick.axes[ABS_Y] = PadAxis{0, 0, 255};
  EXPECT_TRUE(is_gamepad(stick));
  PadInfo touchpad;
  touchpad.buttons.set(BTN_TOUCH).set(BTN_LEFT).set(BTN_TOOL_FINGER);
  touchpad.axes[ABS_X] = touchpad.axes[ABS_Y] = PadAxis{0, 0, 2000};
  EXPECT_FALSE(is_gamepad(touchpad));
  PadInfo motion;  // of a DualShock: axes and no button
  motion.axes[ABS_X] = motion.axes[ABS_Y] = PadAxis{0, -100, 100};
  EXPECT_FALSE(is_gamepad(motion));
  PadInfo keyboard;
  keyboard.buttons.set(KEY_A).set(KEY_ENTER);
  EXPECT_FALSE(is_gamepad(keyboard));
}

}  // namespace
}  // namespace nacelle::joy
