// SPDX-License-Identifier: Apache-2.0
#include "joy/model/joy_pacer.hpp"

#include <gtest/gtest.h>

namespace nacelle::joy {
namespace {

using Change = PadState::Change;
constexpr MonotonicTime kNow{10s};
constexpr MonotonicTime kLater{11s};

TEST(JoyPacer, publishes_a_button_at_once) {
  JoyPacer pacer{{.coalesce = 5ms, .repeat = {}}};
  EXPECT_TRUE(pacer.on_change(Change::Button, kNow));
  EXPECT_FALSE(pacer.on_change(Change::None, kNow));
}

TEST(JoyPacer, gathers_moves_of_axes_for_the_coalesce_interval) {
  JoyPacer pacer{{.coalesce = 5ms, .repeat = {}}};
  EXPECT_FALSE(pacer.on_change(Change::Axis, kNow));
  EXPECT_FALSE(pacer.on_change(Change::Axis, kNow + 4ms)) << "counted from the first move";
  EXPECT_EQ(pacer.next(kLater), kNow + 5ms);
  EXPECT_TRUE(pacer.is_due(kNow + 5ms));
  pacer.on_published(kNow + 5ms);
  EXPECT_EQ(pacer.next(kLater), kLater);
  EXPECT_TRUE(JoyPacer({.coalesce = {}, .repeat = {}}).on_change(Change::Axis, kNow));
}

TEST(JoyPacer, publishes_a_gathered_move_with_a_button) {
  JoyPacer pacer{{.coalesce = 5ms, .repeat = {}}};
  EXPECT_FALSE(pacer.on_change(Change::Axis, kNow));
  EXPECT_TRUE(pacer.on_change(Change::Button, kNow + 1ms));
  pacer.on_published(kNow + 1ms);
  EXPECT_FALSE(pacer.waits());
}

TEST(JoyPacer, repeats_an_unchanged_state) {
  JoyPacer pacer{{.coalesce = 1ms, .repeat = 50ms}};
  EXPECT_TRUE(pacer.is_due(kNow)) << "nothing was published yet";
  pacer.on_published(kNow);
  EXPECT_FALSE(pacer.is_due(kNow + 49ms));
  EXPECT_TRUE(pacer.is_due(kNow + 50ms));
  EXPECT_EQ(pacer.next(kLater), kNow + 50ms);
}

TEST(JoyPacer, restart_forgets_a_move) {
  JoyPacer pacer{{.coalesce = 1ms, .repeat = {}}};
  EXPECT_FALSE(pacer.on_change(Change::Axis, kNow));
  pacer.restart();
  EXPECT_FALSE(pacer.is_due(kNow + 1s));
}

}  // namespace
}  // namespace nacelle::joy
