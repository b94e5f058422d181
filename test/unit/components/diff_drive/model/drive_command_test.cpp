// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/drive_command.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace nacelle::diff_drive {
namespace {

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

}  // namespace
}  // namespace nacelle::diff_drive
