// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/odrive_can_board.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "../port/can_rig.hpp"

namespace nacelle::diff_drive {
namespace {

using Device = simulation::OdriveCanDevice::Settings;
constexpr std::uint32_t kEstimates = 0x09, kBusVoltage = 0x17, kRemoteFlag = 0x40000000;

bool is_estimate_of(const Bytes& frame, std::uint32_t node) { return id_of(frame) == ((node << 5) | kEstimates); }

TEST(OdriveCanBoard, a_start_clears_errors_and_requests_closed_loop_control_of_both_axes) {
  OdriveCanRig rig;
  rig.odrive().axis(0).error = 0x40;  // of yesterday
  ASSERT_TRUE(rig.port().start());
  rig.turn(1ms);
  for (const std::size_t index : {0U, 1U}) {
    const auto& axis = rig.odrive().axis(index);
    EXPECT_EQ(axis.error, 0U);
    EXPECT_EQ(axis.state, 8);
    EXPECT_EQ(axis.control_mode, 2U);
    EXPECT_EQ(axis.input_mode, 1U);
  }
  rig.run(500ms);
  EXPECT_EQ(rig.fault, nullptr) << "heartbeats of before the start do not count";
  EXPECT_EQ(rig.odrive().bad_frames(), 0U);
}

TEST(OdriveCanBoard, the_stop_frame_is_a_whole_frame_for_each_wheel) {
  OdriveCanRig rig{{.nodes = {3, 17}}, {.wiring = {{3, false}, {17, false}, 1.0}}};
  const ByteView stop = rig.port().stop_frame();
  ASSERT_EQ(stop.size(), 32U);
  EXPECT_EQ(id_of({stop.begin(), stop.begin() + 16}), 0x06DU);
  EXPECT_EQ(id_of({stop.begin() + 16, stop.end()}), 0x22DU);
}

TEST(OdriveCanBoard, an_axis_error_is_a_fault_until_a_start) {
  OdriveCanRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(500ms);
  rig.odrive().axis(1).error = 0x200;
  rig.run(150ms);
  ASSERT_NE(rig.fault, nullptr);
  EXPECT_EQ(std::string_view{rig.fault}.substr(0, 25), "right ODrive axis: an err");
  ASSERT_TRUE(rig.port().start());
  rig.run(500ms);
  EXPECT_EQ(rig.fault, nullptr);
}

TEST(OdriveCanBoard, an_axis_that_is_not_in_closed_loop_control_is_a_fault) {
  OdriveCanRig rig;
  rig.odrive().axis(0).is_calibrated = false;
  ASSERT_TRUE(rig.port().start());
  rig.run(500ms);
  ASSERT_NE(rig.fault, nullptr);
  EXPECT_EQ(std::string_view{rig.fault}.substr(0, 25), "left ODrive axis: not in ");
}

TEST(OdriveCanBoard, a_missing_heartbeat_is_a_fault_because_errors_would_be_missed) {
  OdriveCanRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(500ms);
  rig.bus().loses = [](const Bytes& frame) { return id_of(frame) == 0x021; };
  rig.run(800ms);
  EXPECT_EQ(rig.fault, nullptr) << "some may be lost";
  rig.run(400ms);
  ASSERT_NE(rig.fault, nullptr);
  EXPECT_EQ(std::string_view{rig.fault}.substr(0, 30), "right ODrive axis: no heartbea");
  rig.bus().loses = [](const Bytes&) { return false; };
  rig.run(150ms);
  EXPECT_EQ(rig.fault, nullptr);
}

TEST(OdriveCanBoard, an_axis_watchdog_set_in_odrivetool_stops_a_silent_hosts_wheels) {
  OdriveCanRig rig{{.watchdog_s = 0.5}};
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.bus().loses = [](const Bytes&) { return true; };
  rig.turn(600ms);
  EXPECT_EQ(rig.device().left_target_rps(), 0.0);
  EXPECT_EQ(rig.odrive().axis(1).error, 0x800U);
}

TEST(OdriveCanBoard, an_axis_that_sends_no_estimates_is_asked_for_them) {
  OdriveCanRig rig{{.estimates = {0ms, 10ms}}};
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, -1.5}));
  rig.run(200ms);
  const WheelState state = rig.run(200ms);
  EXPECT_NEAR(state.rates.left_rps, 3.0, 2e-3);
  EXPECT_NEAR(state.rates.right_rps, -1.5, 2e-3);
  EXPECT_GE(rig.heard.states.size(), 8U);
  const auto& written = rig.bus().written;
  EXPECT_TRUE(std::any_of(written.begin(), written.end(),
                          [](const Bytes& frame) { return id_of(frame) == (kRemoteFlag | kEstimates); }));
  EXPECT_FALSE(std::any_of(written.end() - 8, written.end(), [](const Bytes& frame) {
    return id_of(frame) == (kRemoteFlag | 0x20 | kEstimates);
  })) << "the other one sends by itself";
}

TEST(OdriveCanBoard, the_voltage_is_asked_for_once_a_second) {
  OdriveCanRig rig;
  rig.odrive().set_voltage(23.5F);
  ASSERT_TRUE(rig.port().start());
  rig.run(3s);
  EXPECT_NEAR(rig.run(20ms).voltage_v.value_or(0.0), 23.5, 1e-6);
  const auto& written = rig.bus().written;
  EXPECT_NEAR(static_cast<double>(
                  std::count_if(written.begin(), written.end(),
                                [](const Bytes& frame) { return id_of(frame) == (kRemoteFlag | kBusVoltage); })),
              4.0, 1.0);
}

TEST(OdriveCanBoard, a_lost_estimate_of_one_wheel_leaves_the_other_not_one_behind) {
  OdriveCanRig rig;
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({3.0, 3.0}));
  rig.run(200ms);
  bool lost = false;
  rig.bus().loses = [&](const Bytes& frame) { return is_estimate_of(frame, 0) && !std::exchange(lost, true); };
  rig.run(300ms);
  EXPECT_TRUE(lost);
  ASSERT_GE(rig.heard.states.size(), 25U);
  for (const WheelState& state : rig.heard.states)
    ASSERT_NEAR(state.left_rad, state.right_rad, 1e-4) << "10 ms apart they would differ by 0.03 rad";
}

TEST(OdriveCanBoard, axes_of_two_boards_at_different_phases_are_read_at_their_rate) {
  OdriveCanRig rig{{.phases = {0ms, 4ms}}};
  ASSERT_TRUE(rig.port().start());
  rig.run(100ms);
  rig.run(1s);
  EXPECT_GE(rig.heard.states.size(), 95U);
}

TEST(OdriveCanBoard, one_axis_alone_makes_no_state_so_that_the_loop_notices_its_loss) {
  OdriveCanRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.run(100ms);
  rig.odrive().axis(1).is_silent = true;
  rig.turn(20ms);
  rig.heard.states.clear();
  rig.turn(1s);
  EXPECT_TRUE(rig.heard.states.empty());
  rig.odrive().axis(1).is_silent = false;
  rig.turn(100ms);
  EXPECT_FALSE(rig.heard.states.empty());
}

TEST(OdriveCanBoard, bus_off_and_a_full_queue_are_faults_of_the_line) {
  OdriveCanRig rig;
  ASSERT_TRUE(rig.port().start());
  rig.bus().fault = io::StreamFault::BusOff;
  rig.hear();
  EXPECT_EQ(rig.fault_of_bus, BaseFault::BusOff);
  rig.bus().fault = io::StreamFault::LineDown;
  rig.hear();
  EXPECT_EQ(rig.fault_of_bus, BaseFault::LineDown);
  rig.bus().write_fault = io::StreamFault::WouldBlock;
  EXPECT_EQ(rig.port().write({1.0, 1.0}).error(), BaseFault::LineStuck);
  EXPECT_EQ(rig.port().stats().stuck, 1U);
}

TEST(OdriveCanBoard, a_bus_off_of_before_the_start_counts_only_if_it_lasts) {
  OdriveCanRig rig;
  rig.bus().fault = io::StreamFault::BusOff;
  EXPECT_TRUE(rig.port().start()) << "it was restarted meanwhile";
  rig.turn(1ms);
  EXPECT_EQ(rig.odrive().axis(1).state, 8);
  rig.bus().fault = io::StreamFault::BusOff;
  rig.bus().fault_of_reopen = io::StreamFault::BusOff;
  EXPECT_EQ(rig.port().start().error(), BaseFault::BusOff);
}

TEST(OdriveCanBoard, reversed_wheels_and_other_nodes_are_the_wirings) {
  OdriveCanRig rig{{.nodes = {5, 2}}, {.wiring = {{5, true}, {2, false}, 4.0}}};
  ASSERT_TRUE(rig.port().start());
  ASSERT_TRUE(rig.port().write({1.0, 1.0}));
  rig.run(50ms);
  EXPECT_NEAR(rig.device().left_target_rps(), -4.0, 1e-5) << "of the motor, behind a gear of 4";
  EXPECT_NEAR(rig.device().right_target_rps(), 4.0, 1e-5);
  const WheelState state = rig.run(100ms);
  EXPECT_NEAR(state.rates.left_rps, 1.0, 2e-3);
  EXPECT_NEAR(state.rates.right_rps, 1.0, 2e-3);
}

}  // namespace
}  // namespace nacelle::diff_drive
