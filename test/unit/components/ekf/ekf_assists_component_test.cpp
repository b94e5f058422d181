// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include "ekf_node.hpp"
#include "support/log_lines.hpp"

namespace nacelle::ekf {
namespace {

class EkfAssists : public EkfNode {
 protected:
  void turn_on(const char* name) { options_.append_parameter_override(name, true); }
  void give_inputs() {
    options_.append_parameter_override("odom0", std::string{"odom"});
    options_.append_parameter_override("odom0_config", config_of({kVx, kVy}));
    options_.append_parameter_override("imu0", std::string{"imu/data_raw"});
    options_.append_parameter_override("imu0_config", config_of({kVyaw}));
  }
  std::string refusal() {
    Node node{"ekf", options_};
    declare_ekf_parameters(node);
    const auto read = read_ekf_parameters(node);
    EXPECT_FALSE(read);
    return read ? "" : read.error().text();
  }
  double yaw() {
    const auto q = filtered().back().pose.pose.orientation;
    return 2.0 * std::atan2(q.z, q.w);
  }
  std::string diagnostic(std::string_view name, std::string_view key) {
    const auto all = context_.published<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics");
    if (all.empty()) return "";
    for (const auto& status : all.back().status) {
      if (status.name != name) continue;
      if (key.empty()) return std::string{status.message};
      for (const auto& value : status.values) {
        if (value.key == key) return std::string{value.value};
      }
    }
    return "";
  }
};

TEST_F(EkfAssists, all_are_off_by_default) {
  Node node{"ekf", options_};
  declare_ekf_parameters(node);
  const auto read = read_ekf_parameters(node);
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->filter.assists.any());
  for (const InputOptions& input : read->inputs) EXPECT_EQ(input.witness, Witness::Source::None);
}

TEST_F(EkfAssists, the_gyros_bias_is_learnt_while_the_robot_stands) {
  give_inputs();
  for (const char* name : {"imu0_estimate_gyro_bias", "odom0_zero_velocity_updates", "print_diagnostics"})
    turn_on(name);
  start();
  for (int i = 0; i < 250; ++i) run(0.0, 0.0);
  EXPECT_NE(diagnostic("ekf: standstill", "zero_velocity_updates"), "0");
  EXPECT_EQ(diagnostic("ekf: standstill", ""), "stands");
  for (int i = 0; i < 250; ++i) {
    context_.advance(9ms);
    send_imu(0.01);
    context_.advance(9ms);
    send_imu(0.01);
    send_odometry(0.0, 0.0);
    context_.advance(2ms);
  }
  EXPECT_EQ(diagnostic("ekf: standstill", ""), "the wheels stand, the IMU moves") << "it was not there before";
  EXPECT_NEAR(yaw(), 0.05, 0.01) << "so the gyro is believed";
}

TEST_F(EkfAssists, a_gyro_with_a_bias_does_not_turn_a_robot_that_stands) {
  give_inputs();
  for (const char* name : {"imu0_estimate_gyro_bias", "odom0_zero_velocity_updates", "print_diagnostics"})
    turn_on(name);
  start();
  for (int i = 0; i < 500; ++i) {
    context_.advance(9ms);
    send_imu(0.01);
    context_.advance(9ms);
    send_imu(0.01);
    send_odometry(0.0, 0.0);
    context_.advance(2ms);
  }
  EXPECT_NEAR(yaw(), 0.0, 0.002) << "without: 0.1 rad";
  EXPECT_NEAR(std::stod(diagnostic("ekf: gyro bias", "z_rps")), 0.01, 0.001);
}

TEST_F(EkfAssists, wheels_that_slip_are_shown) {
  give_inputs();
  for (const char* name : {"odom0_detect_slip", "print_diagnostics"}) turn_on(name);
  start();
  for (int i = 0; i < 100; ++i) run(0.0, 0.0);
  const test::LogLines lines;
  for (int i = 0; i < 60; ++i) {
    context_.advance(9ms);
    send_imu(0.0);
    context_.advance(9ms);
    send_imu(0.0);
    send_odometry(0.8, 1.0);
    context_.advance(2ms);
  }
  EXPECT_EQ(diagnostic("ekf: slip", "episodes"), "1");
  EXPECT_EQ(
      std::ranges::count_if(lines.all, [](const auto& line) { return line.starts_with("odom0: the wheels slip"); }), 1);
  EXPECT_LT(filtered().back().pose.pose.position.x, 0.1) << "without: nearly 1 m";
}

TEST_F(EkfAssists, one_switch_of_a_kind_and_only_where_it_can_work) {
  give_inputs();
  options_.append_parameter_override("imu1", std::string{"other"});
  options_.append_parameter_override("imu1_config", config_of({kVyaw}));
  turn_on("imu0_estimate_gyro_bias");
  turn_on("imu1_estimate_gyro_bias");
  const std::string twice = refusal();
  EXPECT_NE(twice.find("imu1_estimate_gyro_bias"), std::string::npos) << twice;
}

TEST_F(EkfAssists, wheels_whose_velocity_is_not_fused_are_refused) {
  options_.append_parameter_override("odom0", std::string{"odom"});
  options_.append_parameter_override("odom0_config", config_of({kX, kY, kYaw}));
  turn_on("odom0_zero_velocity_updates");
  EXPECT_NE(refusal().find("odom0_config"), std::string::npos);
}

TEST_F(EkfAssists, a_number_that_is_not_positive_is_refused) {
  options_.append_parameter_override("standstill_time", 0.0);
  EXPECT_NE(refusal().find("standstill_time"), std::string::npos);
}

}  // namespace
}  // namespace nacelle::ekf
