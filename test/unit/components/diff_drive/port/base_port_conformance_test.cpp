// SPDX-License-Identifier: Apache-2.0
// The laws of BasePort, from its doc comment; every implementation passes them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base_rig.hpp"
#include "can_rig.hpp"
#include "emulated_rig.hpp"
#include "pwm_tree.hpp"

namespace nacelle::diff_drive {
namespace {

template <typename Rig>
class BasePortLaws : public ::testing::Test {
 protected:
  Rig rig_;
  BasePort& port_ = rig_.port();
};
using EveryBase = ::testing::Types<LoopbackRig, WaveshareRig, RoboclawRig, VescRig, OdriveRig, HiwonderRig,
                                   OdriveCanRig, VescCanRig, FramedRig, TextRig, PwmRig>;
TYPED_TEST_SUITE(BasePortLaws, EveryBase);

TYPED_TEST(BasePortLaws, the_wheels_stand_still_until_the_first_command) {
  ASSERT_TRUE(this->port_.start());
  const WheelState first = this->rig_.run(100ms);
  const WheelState second = this->rig_.run(100ms);
  EXPECT_EQ(first.rates, WheelRates{});
  EXPECT_EQ(first.left_rad, second.left_rad);
  EXPECT_EQ(first.right_rad, second.right_rad);
}

TYPED_TEST(BasePortLaws, the_wheels_follow_the_command) {
  ASSERT_TRUE(this->port_.start());
  const WheelState before = this->rig_.run(20ms);
  ASSERT_TRUE(this->port_.write({3.0, -1.5}));
  this->rig_.run(20ms);
  const WheelState start = this->rig_.run(20ms);
  const WheelState end = this->rig_.run(1s);
  // A command has a resolution of 0.1 mm/s at the rim.
  EXPECT_NEAR(end.rates.left_rps, 3.0, 2e-3);
  EXPECT_NEAR(end.rates.right_rps, -1.5, 2e-3);
  EXPECT_NEAR(end.left_rad - start.left_rad, 3.0, 4e-3);
  EXPECT_NEAR(end.right_rad - start.right_rad, -1.5, 4e-3);
  EXPECT_GT(start.left_rad, before.left_rad);
}

TYPED_TEST(BasePortLaws, a_stop_stops) {
  ASSERT_TRUE(this->port_.start());
  ASSERT_TRUE(this->port_.write({3.0, 3.0}));
  this->rig_.run(100ms);
  ASSERT_TRUE(this->port_.stop());
  const WheelState first = this->rig_.run(20ms);
  const WheelState second = this->rig_.run(500ms);
  EXPECT_EQ(second.rates, WheelRates{});
  EXPECT_EQ(first.left_rad, second.left_rad);
}

TYPED_TEST(BasePortLaws, a_start_stops_wheels_that_turn) {
  ASSERT_TRUE(this->port_.start());
  ASSERT_TRUE(this->port_.write({3.0, 3.0}));
  this->rig_.run(100ms);
  ASSERT_TRUE(this->port_.start());
  EXPECT_EQ(this->rig_.run(100ms).rates, WheelRates{});
}

TYPED_TEST(BasePortLaws, the_stop_frame_stops_the_wheels_from_any_writer) {
  ASSERT_TRUE(this->port_.start());
  ASSERT_TRUE(this->port_.write({3.0, 3.0}));
  EXPECT_NEAR(this->rig_.run(100ms).rates.left_rps, 3.0, 2e-3);
  if (this->port_.stop_frame().empty()) {
    EXPECT_EQ(this->port_.descriptor(), -1);
    return;
  }
  ASSERT_GE(this->port_.descriptor(), 0);
  this->rig_.write_as_stranger(this->port_.stop_frame());
  const auto heard_before = this->rig_.states;
  EXPECT_EQ(this->rig_.rates_after(100ms), WheelRates{});
  EXPECT_GT(this->rig_.states, heard_before);
}

TYPED_TEST(BasePortLaws, the_stop_frame_stops_the_wheels_behind_half_a_command) {
  ASSERT_TRUE(this->port_.start());
  ASSERT_TRUE(this->port_.write({3.0, 3.0}));
  EXPECT_NEAR(this->rig_.run(100ms).rates.left_rps, 3.0, 2e-3);
  const ByteView stop = this->port_.stop_frame();
  if (stop.empty() || !this->rig_.can_tear()) return;
  const auto frame =
      std::find_if(stop.begin(), stop.end(), [](std::uint8_t byte) { return byte != 0 && byte != '\n'; });
  Bytes torn(frame, stop.end() - 1);
  torn.insert(torn.end(), stop.begin(), stop.end());
  this->rig_.write_as_stranger(torn);
  EXPECT_EQ(this->rig_.rates_after(100ms), WheelRates{});
}

TYPED_TEST(BasePortLaws, rates_that_no_command_can_carry_are_refused_and_change_nothing) {
  ASSERT_TRUE(this->port_.start());
  ASSERT_TRUE(this->port_.write({1.0, 1.0}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(this->port_.write({nan, 0.0}).error(), BaseFault::NotSendable);
  EXPECT_EQ(this->port_.write({0.0, std::numeric_limits<double>::infinity()}).error(), BaseFault::NotSendable);
  EXPECT_NEAR(this->rig_.run(100ms).rates.left_rps, 1.0, 2e-3);
}

TYPED_TEST(BasePortLaws, the_highest_rate_can_be_commanded) {
  ASSERT_TRUE(this->port_.start());
  const double most = this->port_.max_wheel_rate();
  if (std::isinf(most)) return;
  ASSERT_TRUE(this->port_.write({most, -most}));
  EXPECT_NEAR(this->rig_.run(100ms).rates.left_rps, most, 2e-3);
  EXPECT_EQ(this->port_.write({most * 1.01, 0.0}).error(), BaseFault::NotSendable);
}

TYPED_TEST(BasePortLaws, a_deadline_in_the_past_does_not_wait) {
  ASSERT_TRUE(this->port_.start());
  Heard heard;
  EXPECT_TRUE(this->port_.read_until({}, heard));
  EXPECT_TRUE(heard.states.empty());
}

TYPED_TEST(BasePortLaws, states_and_commands_are_counted) {
  ASSERT_TRUE(this->port_.start());
  const auto before = this->port_.stats();
  const auto heard_before = this->rig_.states;
  ASSERT_TRUE(this->port_.write({1.0, 1.0}));
  ASSERT_TRUE(this->port_.stop());
  this->rig_.run(200ms);  // a board that was asked while its line was flushed is asked again
  EXPECT_EQ(this->port_.stats().commands, before.commands + 2);
  EXPECT_GT(this->rig_.states, heard_before);
  EXPECT_EQ(this->port_.stats().states - before.states, this->rig_.states - heard_before);
}

}  // namespace
}  // namespace nacelle::diff_drive
