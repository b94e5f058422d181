// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/hindrance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::diff_drive {
namespace {

using diagnostic_msgs::msg::DiagnosticStatus;
using ::testing::HasSubstr;

DriveLoop::Look held_by(std::initializer_list<Hold> holds) {
  DriveLoop::Look look;
  look.state = CommandInput::State::Held;
  for (const Hold hold : holds) look.holds |= static_cast<std::uint8_t>(hold);
  return look;
}

TEST(Hindrance, is_none_while_the_base_follows) {
  EXPECT_TRUE(hindrance_of({}, nullptr).text.empty());
  EXPECT_EQ(hindrance_of({}, nullptr).level, DiagnosticStatus::OK);
}

TEST(Hindrance, of_an_inactive_controller_names_it_and_the_way_out) {
  const Hindrance hindrance = hindrance_of(held_by({Hold::Inactive}), nullptr);
  EXPECT_THAT(hindrance.text, HasSubstr("diff_drive_controller is not active"));
  EXPECT_THAT(hindrance.text, HasSubstr("switch_controllers --activate"));
  EXPECT_EQ(hindrance.level, DiagnosticStatus::WARN);
}

TEST(Hindrance, of_several_is_the_worst) {
  EXPECT_THAT(hindrance_of(held_by({Hold::Inactive, Hold::EmergencyStop}), nullptr).text, HasSubstr("emergency stop"));
  EXPECT_THAT(hindrance_of(held_by({Hold::EmergencyStop, Hold::LineLost}), nullptr).text, HasSubstr("disconnected"));
  EXPECT_EQ(hindrance_of(held_by({Hold::Inactive, Hold::BoardFault}), "too hot").text,
            "the motor board reports a fault: too hot");
}

}  // namespace
}  // namespace nacelle::diff_drive
