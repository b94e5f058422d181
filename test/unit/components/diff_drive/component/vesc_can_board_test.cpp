// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/vesc_can_board.hpp"

#include <gtest/gtest.h>

#include "../port/can_rig.hpp"

namespace nacelle::diff_drive {
namespace {

TEST(VescCanBoard, drives_both) {
  VescCanRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, -1.0}));
  rig.turn(1ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-3);
  EXPECT_NEAR(rig.device().right_target_rps(), -1.0, 1e-3);
}

TEST(VescCanBoard, the_stop_frame_is_a_whole_frame_for_each_wheel) {
  VescCanRig rig;
  const ByteView stop = rig.port().stop_frame();
  ASSERT_EQ(stop.size(), 32U);
  EXPECT_EQ(id_of({stop.begin(), stop.begin() + 16}), 0x80000007U);
  EXPECT_EQ(id_of({stop.begin() + 16, stop.end()}), 0x8000002AU);
}

TEST(VescCanBoard, reports_the_battery) {
  VescCanRig rig;
  rig.vesc().set_voltage(36.4);
  ASSERT_TRUE(rig.port().start());
  EXPECT_NEAR(rig.run(60ms).voltage_v.value_or(0.0), 36.4, 1e-9);
}

TEST(VescCanBoard, reports_the_fault_of_either) {
  VescCanRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(150ms);
  EXPECT_EQ(rig.fault, nullptr);
  rig.vesc().set_fault(1, 4);
  rig.run(150ms);
  EXPECT_STREQ(rig.fault, "right VESC: absolute over-current");
  rig.vesc().set_fault(0, 2);
  rig.run(150ms);
  EXPECT_STREQ(rig.fault, "left VESC: voltage too low");
  rig.vesc().set_fault(0, 0);
  rig.vesc().set_fault(1, 0);
  rig.run(150ms);
  EXPECT_EQ(rig.fault, nullptr);
}

TEST(VescCanBoard, a_lost_status_of_one_wheel_leaves_the_other_not_one_behind) {
  for (const std::uint32_t message : {9U, 27U}) {
    VescCanRig rig;
    ASSERT_TRUE(rig.port().start());
    ASSERT_TRUE(rig.port().write({3.0, 3.0}));
    rig.run(200ms);
    bool lost = false;
    rig.bus().loses = [&](const Bytes& frame) {
      return id_of(frame) == (0x80000007U | (message << 8)) && !std::exchange(lost, true);
    };
    rig.run(300ms);
    EXPECT_TRUE(lost);
    ASSERT_GE(rig.heard.states.size(), 13U);
    for (const WheelState& state : rig.heard.states)
      ASSERT_NEAR(state.left_rad, state.right_rad, 1e-3)
          << "20 ms apart they would differ by 0.06 rad; message " << message;
  }
}

TEST(VescCanBoard, boards_at_opposite_phases_are_read_at_their_rate) {
  VescCanRig rig{{.pole_pairs = VescCanRig::kPolePairs, .phases = {0ms, 10ms}}};
  ASSERT_TRUE(rig.port().start());
  rig.run(100ms);
  rig.run(1s);
  EXPECT_GE(rig.heard.states.size(), 45U);
}

TEST(VescCanBoard, one_alone_makes_no_state_so_that_the_loop_notices_its_loss) {
  VescCanRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(100ms);
  rig.vesc().set_silent(1, true);
  rig.heard.states.clear();
  rig.turn(1s);
  EXPECT_TRUE(rig.heard.states.empty());
  rig.vesc().set_silent(1, false);
  rig.turn(100ms);
  EXPECT_FALSE(rig.heard.states.empty());
}

TEST(VescCanBoard, the_vescs_stop_by_themselves_when_the_host_is_silent) {
  VescCanRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.turn(2100ms);
  EXPECT_EQ(rig.device().left_target_rps(), 0.0);
  EXPECT_EQ(rig.device().right_target_rps(), 0.0);
  EXPECT_EQ(rig.vesc().timeouts(), 2U) << "questions for faults keep nothing alive";
}

}  // namespace
}  // namespace nacelle::diff_drive
