// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/hiwonder_board.hpp"

#include <gtest/gtest.h>

#include "../port/emulated_rig.hpp"

namespace nacelle::diff_drive {
namespace {

TEST(HiwonderBoard, drives_two_motors_and_states_that_the_wheels_turn_as_commanded) {
  HiwonderRig rig;
  ASSERT_TRUE(rig.port().start());
  const WheelState before = rig.run(20ms);
  ASSERT_TRUE(rig.port().write({3.0, -1.0}));
  const WheelState state = rig.run(100ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-6);
  EXPECT_NEAR(rig.device().right_target_rps(), -1.0, 1e-6);
  EXPECT_EQ(state.rates, (WheelRates{3.0, -1.0}));
  EXPECT_NEAR(state.left_rad - before.left_rad, 0.3, 1e-9);
  EXPECT_NEAR(state.right_rad - before.right_rad, -0.1, 1e-9);
}

TEST(HiwonderBoard, commands_turns_of_the_motors_shaft_in_its_own_direction) {
  HiwonderRig rig{{.wiring = {{3, false}, {4, true}, 2.0}}};
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  const WheelState state = rig.run(20ms);
  EXPECT_NEAR(rig.hiwonder().speed_of(2), 6.0, 1e-6);
  EXPECT_NEAR(rig.hiwonder().speed_of(3), -6.0, 1e-6);
  EXPECT_EQ(rig.hiwonder().speed_of(0), 0.0);
  EXPECT_EQ(state.rates, (WheelRates{3.0, 3.0}));
}

TEST(HiwonderBoard, changes_of_the_command_between_two_states_are_integrated) {
  HiwonderRig rig;
  ASSERT_TRUE(rig.port().start());
  const WheelState before = rig.run(20ms);
  ASSERT_TRUE(rig.port().write({10.0, 10.0}));
  rig.turn(30ms);
  ASSERT_TRUE(rig.port().write({-10.0, 10.0}));
  rig.turn(10ms);
  ASSERT_TRUE(rig.port().stop());
  const WheelState state = rig.run(50ms);
  EXPECT_NEAR(state.left_rad - before.left_rad, 0.2, 1e-9);
  EXPECT_NEAR(state.right_rad - before.right_rad, 0.4, 1e-9);
  EXPECT_EQ(state.rates, WheelRates{});
}

TEST(HiwonderBoard, a_restart_keeps_the_angles) {
  HiwonderRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  const WheelState before = rig.run(100ms);
  ASSERT_TRUE(rig.port().start());
  const WheelState after = rig.run(100ms);
  EXPECT_EQ(after.left_rad, before.left_rad);
  EXPECT_EQ(rig.port().stats().board_restarts, 0U);
}

TEST(HiwonderBoard, reports_the_battery) {
  HiwonderRig rig;
  rig.hiwonder().set_battery_mv(11850);
  ASSERT_TRUE(rig.port().start());
  EXPECT_NEAR(rig.run(1100ms).voltage_v.value_or(0.0), 11.85, 1e-9);
}

TEST(HiwonderBoard, states_nothing_before_the_board_has_spoken) {
  HiwonderRig rig;
  rig.hiwonder().silence(true);
  ASSERT_TRUE(rig.port().start());
  rig.turn(100ms);
  rig.settle();
  EXPECT_EQ(rig.states, 0U);
  EXPECT_EQ(rig.port().stats().states, 0U);
}

TEST(HiwonderBoard, a_board_that_falls_silent_makes_no_states_so_that_the_loop_notices_its_loss) {
  HiwonderRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  rig.hiwonder().silence(true);
  rig.turn(3s);
  rig.settle();
  const auto heard = rig.states;
  EXPECT_GT(heard, 1U);
  rig.turn(300ms);
  rig.settle();
  EXPECT_EQ(rig.states, heard);
  rig.hiwonder().silence(false);
  rig.run(20ms);
  EXPECT_GT(rig.states, heard);
}

TEST(HiwonderBoard, the_battery_alone_keeps_a_board_with_a_broken_imu_alive) {
  HiwonderRig rig;
  rig.hiwonder().break_imu();
  ASSERT_TRUE(rig.port().start());
  rig.run(1100ms);
  for (int i = 0; i < 200; ++i) {
    const auto heard = rig.states;
    rig.run(20ms);
    ASSERT_GT(rig.states, heard) << i;
  }
}

TEST(HiwonderBoard, the_board_has_no_watchdog_and_its_wheels_keep_their_speed) {
  HiwonderRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.run(20ms);
  rig.turn(10s);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-6);
}

TEST(HiwonderBoard, half_a_command_at_any_byte_does_not_hide_the_stop_behind_it) {
  HiwonderPrinter printer{1, 2};
  const ByteView speeds = printer.speeds(0.5F, 0.5F);
  const Bytes whole(speeds.begin(), speeds.end());
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    HiwonderBoard board{HiwonderBoard::Settings{}};
    simulation::HiwonderDevice device;
    static_cast<void>(device.on_bytes(whole, {}));
    static_cast<void>(device.on_bytes(ByteView{whole}.first(cut), {}));
    static_cast<void>(device.on_bytes(board.separator(), {}));
    static_cast<void>(device.on_bytes(board.stop_frame(), {}));
    EXPECT_EQ(device.left_target_rps(), 0.0) << cut;
    EXPECT_EQ(device.right_target_rps(), 0.0) << cut;
  }
}

TEST(HiwonderBoard, skips_a_damaged_report) {
  HiwonderRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  bool damaged = false;
  rig.on_answer = [&](Bytes& answer) {
    if (!std::exchange(damaged, true)) answer[6] ^= 1;
  };
  rig.run(20ms);
  EXPECT_TRUE(damaged);
  EXPECT_GT(rig.port().stats().bytes_lost, 0U);
}

}  // namespace
}  // namespace nacelle::diff_drive
