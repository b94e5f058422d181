// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/vesc_board.hpp"

#include <gtest/gtest.h>

#include "../port/emulated_rig.hpp"

namespace nacelle::diff_drive {
namespace {

TEST(VescBoard, drives_the_one_on_the_line_and_the_one_behind_it) {
  VescRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, -1.0}));
  rig.run(20ms);
  EXPECT_NEAR(rig.device().left_target_rps(), 3.0, 1e-3);
  EXPECT_NEAR(rig.device().right_target_rps(), -1.0, 1e-3);
}

TEST(VescBoard, reports_the_battery) {
  VescRig rig;
  rig.vesc().set_voltage(36.4);
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  EXPECT_NEAR(rig.run(20ms).voltage_v.value_or(0.0), 36.4, 1e-9);
}

TEST(VescBoard, reports_the_fault_of_either) {
  VescRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  EXPECT_EQ(rig.fault, nullptr);
  rig.vesc().set_fault(1, 4);
  rig.run(20ms);
  EXPECT_STREQ(rig.fault, "right VESC: absolute over-current");
  rig.vesc().set_fault(0, 25);
  rig.run(20ms);
  EXPECT_STREQ(rig.fault, "left VESC: a fault that `faults` in VESC Tool's terminal names");
  rig.vesc().set_fault(0, 0);
  rig.vesc().set_fault(1, 0);
  rig.run(20ms);
  EXPECT_EQ(rig.fault, nullptr);
}

TEST(VescBoard, one_alone_makes_no_state_so_that_the_loop_notices_its_loss) {
  VescRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  rig.vesc().cut_can(true);
  rig.settle();
  const auto heard = rig.states;
  for (int i = 0; i < 20; ++i) rig.run(20ms);
  EXPECT_EQ(rig.states, heard);
  rig.vesc().cut_can(false);
  rig.run(20ms);
  EXPECT_GT(rig.states, heard);
}

TEST(VescBoard, the_vescs_stop_by_themselves_when_the_host_is_silent) {
  VescRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.run(20ms);
  rig.turn(2100ms);
  EXPECT_EQ(rig.device().left_target_rps(), 0.0);
  EXPECT_EQ(rig.device().right_target_rps(), 0.0);
  EXPECT_EQ(rig.vesc().stats().timeouts, 2U);
}

TEST(VescBoard, skips_a_damaged_answer) {
  VescRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(20ms);
  bool damaged = false;
  rig.on_answer = [&](Bytes& answer) {
    if (!std::exchange(damaged, true)) answer[6] ^= 1;
  };
  rig.run(20ms);
  EXPECT_TRUE(damaged);
  const auto heard = rig.states;
  rig.run(20ms);
  EXPECT_GT(rig.states, heard);
  EXPECT_GT(rig.port().stats().bytes_lost, 0U);
}

}  // namespace
}  // namespace nacelle::diff_drive
