// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/roboclaw_board.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "../port/emulated_rig.hpp"

namespace nacelle::diff_drive {
namespace {

TEST(RoboclawBoard, arms_the_boards_own_watchdog_before_it_reads_the_wheels) {
  RoboclawRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  EXPECT_EQ(rig.roboclaw().timeout_s(), 2.0);
}

TEST(RoboclawBoard, the_board_stops_by_itself_when_the_host_is_silent) {
  RoboclawRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.run(20ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-3);
  rig.turn(1900ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-3);
  rig.turn(200ms);
  EXPECT_EQ(rig.device().left_target_rps(), 0.0);
  EXPECT_EQ(rig.roboclaw().stats().timeouts, 1U);
}

TEST(RoboclawBoard, channels_and_directions_are_the_robots) {
  RoboclawRig rig{{.counts_per_turn = RoboclawRig::kCounts},
                  {.wiring = {{2, true}, {1, false}, RoboclawRig::kCounts}, .motor_watchdog = 2s}};
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, -1.0}));
  rig.run(20ms);
  EXPECT_NEAR(rig.device().left_target_rps(), -1.0, 1e-3) << "M1 is the right wheel";
  EXPECT_NEAR(rig.device().right_target_rps(), -3.0, 1e-3) << "M2 is the left wheel, reversed";
  const WheelState start = rig.run(20ms);
  const WheelState end = rig.run(1s);
  EXPECT_NEAR(end.left_rad - start.left_rad, 3.0, 1e-3);
  EXPECT_NEAR(end.right_rad - start.right_rad, -1.0, 1e-3);
}

TEST(RoboclawBoard, reports_the_battery) {
  RoboclawRig rig;
  rig.roboclaw().set_battery(11.7);
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  EXPECT_NEAR(rig.run(20ms).voltage_v.value_or(0.0), 11.7, 1e-9);
}

TEST(RoboclawBoard, reports_the_status_word_as_a_fault_and_its_end) {
  for (const bool is_old : {false, true}) {
    RoboclawRig rig{{.counts_per_turn = RoboclawRig::kCounts, .has_old_firmware = is_old}};
    ASSERT_TRUE(rig.port().start());
    rig.run(20ms);
    rig.run(20ms);
    EXPECT_EQ(rig.fault, nullptr);
    rig.roboclaw().set_status(is_old ? 0x100 : 0x40);
    rig.run(20ms);
    rig.run(20ms);
    EXPECT_STREQ(rig.fault, "RoboClaw: fault of the driver of M1");
    rig.roboclaw().set_status(0);
    rig.run(20ms);
    rig.run(20ms);
    EXPECT_EQ(rig.fault, nullptr);
  }
}

TEST(RoboclawBoard, hears_the_board_again_after_a_flipped_bit_and_after_a_lost_answer) {
  for (const bool is_lost : {false, true}) {
    RoboclawRig rig;
    ASSERT_TRUE(rig.port().start());
    ASSERT_TRUE(rig.port().write({3.0, 3.0}));
    rig.run(20ms);
    bool garbled = false;
    rig.on_answer = [&](Bytes& answer) {
      if (std::exchange(garbled, true)) return;
      if (is_lost) {
        answer.clear();
      } else {
        answer[0] ^= 0x10;
      }
    };
    ASSERT_TRUE(rig.port().write({3.0, 3.0}));
    rig.settle();
    EXPECT_TRUE(garbled);
    rig.turn(100ms);
    ASSERT_TRUE(rig.port().write({3.0, 3.0}));
    const auto heard_before = rig.states;
    const WheelState state = rig.run(100ms);
    EXPECT_GT(rig.states, heard_before) << "lost: " << is_lost;
    EXPECT_NEAR(state.rates.left_rps, 3.0, 2e-3);
  }
}

TEST(RoboclawBoard, commands_that_go_on_do_not_hide_a_missing_answer) {
  RoboclawRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  int lost = 0;
  rig.on_answer = [&](Bytes& answer) {
    if (answer.size() > 1 && lost++ == 0) answer.clear();
  };
  std::uint64_t heard_last = 0;
  for (int cycle = 0; cycle < 20; ++cycle) {
    ASSERT_TRUE(rig.port().write({3.0, 3.0}));
    const auto before = rig.states;
    rig.run(20ms);
    heard_last = rig.states - before;
  }
  EXPECT_GE(lost, 1);
  EXPECT_GT(heard_last, 0U);
}

TEST(RoboclawBoard, goes_on_counting_when_the_board_was_reset_and_arms_its_watchdog_again) {
  RoboclawRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({10.0, 10.0}));
  rig.run(20ms);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(rig.port().write({10.0, 10.0}));
    rig.run(200ms);
  }
  const WheelState before = rig.run(20ms);
  EXPECT_GT(before.left_rad, 30.0);
  rig.roboclaw().restart();
  const WheelState after = rig.run(20ms);
  EXPECT_EQ(after.left_rad, before.left_rad);
  EXPECT_EQ(rig.port().stats().board_restarts, 1U);
}

TEST(RoboclawBoard, speaks_magnitudes_too) {
  RoboclawRig rig{{.counts_per_turn = RoboclawRig::kCounts, .sends_magnitudes = true}};
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({-2.0, 2.0}));
  rig.run(20ms);
  const WheelState state = rig.run(100ms);
  EXPECT_NEAR(state.rates.left_rps, -2.0, 2e-3);
  EXPECT_NEAR(state.rates.right_rps, 2.0, 2e-3);
}

}  // namespace
}  // namespace nacelle::diff_drive
