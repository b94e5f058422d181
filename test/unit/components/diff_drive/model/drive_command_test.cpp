// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/drive_command.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace nacelle::diff_drive {
namespace {

constexpr MonotonicTime at(Duration since) { return {since}; }
DriveCommand command(double linear_mps, Duration received) { return {{linear_mps, 0.0}, at(received), at(received)}; }

TEST(CommandFilter, takes_what_a_differential_drive_can_follow) {
  const auto twist = accepted({0.4, 7.0, 0.0, 0.0, 0.0, -1.5});
  ASSERT_TRUE(twist);
  EXPECT_EQ(twist.value(), (BodyTwist{0.4, -1.5}));
}

TEST(CommandFilter, refuses_a_message_with_any_part_that_is_no_number) {
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity()};
  double RawTwist::*const parts[] = {&RawTwist::linear_x,  &RawTwist::linear_y,  &RawTwist::linear_z,
                                     &RawTwist::angular_x, &RawTwist::angular_y, &RawTwist::angular_z};
  for (const double value : bad) {
    for (const auto part : parts) {
      RawTwist twist;
      twist.*part = value;
      ASSERT_FALSE(accepted(twist));
      EXPECT_EQ(accepted(twist).error(), CommandFault::NotFinite);
    }
  }
}

TEST(CommandFilter, refuses_absurd_speeds_but_not_fast_ones) {
  EXPECT_TRUE(accepted({kMaxSaneLinear_mps, 0, 0, 0, 0, -kMaxSaneAngular_rps}));
  EXPECT_EQ(accepted({1e9, 0, 0, 0, 0, 0}).error(), CommandFault::Absurd);
  EXPECT_EQ(accepted({0, 0, 0, 0, 0, -100.1}).error(), CommandFault::Absurd);
}

TEST(CommandWatch, wants_nothing_before_the_first_command) {
  CommandWatch watch{500ms};
  watch.arm(at(1s));
  EXPECT_EQ(watch.state(), CommandWatch::State::Waiting);
  EXPECT_EQ(watch.wanted(at(100s)), BodyTwist{});
  EXPECT_EQ(watch.stats().timeouts, 0U);
}

TEST(CommandWatch, gives_a_command_up_after_the_timeout_and_not_before) {
  CommandWatch watch{500ms};
  watch.arm(at(1s));
  ASSERT_TRUE(watch.take(command(0.3, 2s)));
  EXPECT_EQ(watch.wanted(at(2500ms)).linear_mps, 0.3);
  EXPECT_EQ(watch.wanted(at(2500ms + 1ns)).linear_mps, 0.0);
  EXPECT_EQ(watch.state(), CommandWatch::State::TimedOut);
  EXPECT_EQ(watch.wanted(at(3s)).linear_mps, 0.0);
  EXPECT_EQ(watch.stats().timeouts, 1U);
}

TEST(CommandWatch, stays_stopped_after_a_timeout_until_a_new_command) {
  CommandWatch watch{500ms};
  watch.arm(at(0s));
  watch.take(command(0.3, 1s));
  static_cast<void>(watch.wanted(at(2s)));
  EXPECT_EQ(watch.wanted(at(2s)).linear_mps, 0.0);
  EXPECT_TRUE(watch.take(command(0.1, 3s)));
  EXPECT_EQ(watch.wanted(at(3s)).linear_mps, 0.1);
}

TEST(CommandWatch, drops_commands_from_before_it_was_armed) {
  CommandWatch watch{500ms};
  watch.arm(at(5s));
  EXPECT_FALSE(watch.take(command(0.3, 4999ms)));
  EXPECT_EQ(watch.wanted(at(5s)).linear_mps, 0.0);
  EXPECT_EQ(watch.stats().early, 1U);
}

TEST(CommandWatch, arming_again_forgets_the_command) {
  CommandWatch watch{500ms};
  watch.arm(at(0s));
  watch.take(command(0.3, 1s));
  watch.arm(at(1100ms));
  EXPECT_EQ(watch.wanted(at(1100ms)).linear_mps, 0.0);
  EXPECT_EQ(watch.state(), CommandWatch::State::Waiting);
}

TEST(CommandWatch, never_times_out_with_a_timeout_of_zero) {
  CommandWatch watch{0ms};
  watch.arm(at(0s));
  watch.take(command(0.3, 1s));
  EXPECT_EQ(watch.wanted(at(1h)).linear_mps, 0.3);
}

}  // namespace
}  // namespace nacelle::diff_drive
