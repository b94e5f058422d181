// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/odrive_board.hpp"

#include <gtest/gtest.h>

#include "../port/emulated_rig.hpp"

namespace nacelle::diff_drive {
namespace {

TEST(OdriveBoard, a_start_arms_the_watchdog_and_requests_closed_loop_control) {
  OdriveRig rig;
  rig.odrive().axis(0).error = 0x40;  // of yesterday
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  for (const std::size_t index : {0U, 1U}) {
    const auto& axis = rig.odrive().axis(index);
    EXPECT_EQ(axis.state, 8);
    EXPECT_EQ(axis.error, 0U);
    EXPECT_TRUE(axis.has_watchdog);
    EXPECT_EQ(axis.watchdog_s, 2.0);
    EXPECT_EQ(axis.control_mode, 2);
    EXPECT_EQ(axis.input_mode, 1);
  }
  EXPECT_EQ(rig.odrive().bad_lines(), 0U);
}

TEST(OdriveBoard, its_watchdog_stops_a_silent_hosts_wheels_and_that_is_a_fault) {
  OdriveRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.run(20ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-3);
  rig.turn(2100ms);
  EXPECT_EQ(rig.device().left_target_rps(), 0.0);
  for (int i = 0; i < 6; ++i) rig.run(20ms);
  ASSERT_NE(rig.fault, nullptr);
  EXPECT_EQ(std::string_view{rig.fault}.substr(0, 24), "left ODrive axis: an err");
  ASSERT_TRUE(rig.port().start()) << "a new activation clears it";
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(rig.port().stop());
    rig.run(20ms);
  }
  EXPECT_EQ(rig.fault, nullptr);
}

TEST(OdriveBoard, an_axis_that_does_not_run_is_a_fault) {
  OdriveRig rig;
  rig.odrive().axis(1).is_calibrated = false;
  ASSERT_TRUE(rig.port().start());
  for (int i = 0; i < 6; ++i) rig.run(20ms);
  ASSERT_NE(rig.fault, nullptr);
  EXPECT_EQ(std::string_view{rig.fault}.substr(0, 45), "right ODrive axis: not in closed loop control");
}

TEST(OdriveBoard, reports_the_battery) {
  OdriveRig rig;
  ASSERT_TRUE(rig.port().start());
  WheelState state;
  for (int i = 0; i < 6; ++i) state = rig.run(20ms);
  EXPECT_NEAR(state.voltage_v.value_or(0.0), 23.950001, 1e-6);
}

TEST(OdriveBoard, takes_answers_without_checksums) {
  OdriveRig rig{{.answers_checksums = false}};
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, -1.5}));
  rig.run(20ms);
  EXPECT_NEAR(rig.run(20ms).rates.right_rps, -1.5, 1e-3);
}

TEST(OdriveBoard, a_damaged_and_a_lost_answer_cost_a_round) {
  for (const bool is_lost : {false, true}) {
    OdriveRig rig;
    ASSERT_TRUE(rig.port().start());
    ASSERT_TRUE(rig.port().write({3.0, 3.0}));
    rig.run(20ms);
    bool damaged = false;
    rig.on_answer = [&](Bytes& answer) {
      if (std::exchange(damaged, true)) return;
      if (is_lost) {
        answer.clear();
      } else {
        answer[0] ^= 0x01;
      }
    };
    for (int i = 0; i < 6; ++i) rig.run(20ms);
    EXPECT_TRUE(damaged);
    const auto heard = rig.states;
    const WheelState state = rig.run(100ms);
    EXPECT_GT(rig.states, heard);
    EXPECT_NEAR(state.rates.left_rps, 3.0, 2e-3);
  }
}

}  // namespace
}  // namespace nacelle::diff_drive
