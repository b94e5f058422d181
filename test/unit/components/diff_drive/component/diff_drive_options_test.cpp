// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "diff_drive/component/boards.hpp"

namespace nacelle::diff_drive {
namespace {

using ::testing::HasSubstr;

TEST(DiffDriveOptions, the_defaults_are_valid) {
  const auto setup = validated({}, "/diff_drive");
  ASSERT_TRUE(setup) << setup.error().text();
  EXPECT_EQ(setup.value().loop.period, Duration{20ms});
  EXPECT_EQ(setup.value().loop.input.sources.at(0).timeout, Duration{500ms});
  EXPECT_TRUE(setup.value().warnings.empty());
}

TEST(DiffDriveOptions, multipliers_are_inside_the_geometry) {
  DiffDriveOptions options;
  options.wheel_separation_multiplier = 1.1;
  options.left_wheel_radius_multiplier = 0.9;
  options.right_wheel_radius_multiplier = 1.2;
  const auto geometry = validated(options, "/d").value().loop.geometry;
  EXPECT_DOUBLE_EQ(geometry.wheel_separation_m, 0.33);
  EXPECT_DOUBLE_EQ(geometry.left_wheel_radius_m, 0.033 * 0.9);
  EXPECT_DOUBLE_EQ(geometry.right_wheel_radius_m, 0.033 * 1.2);
}

TEST(DiffDriveOptions, each_mistake_names_node_parameter_value_and_way_out) {
  struct Row {
    const char* parameter;
    const char* value;
    std::function<void(DiffDriveOptions&)> spoil;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Row table[] = {
      {"left_wheel_names", "empty", [](auto& o) { o.left_wheel_names.clear(); }},
      {"right_wheel_names", "empty", [](auto& o) { o.right_wheel_names.clear(); }},
      {"right_wheel_names", "2 on the left", [](auto& o) { o.left_wheel_names.push_back("rear"); }},
      {"right_wheel_names", "named twice", [](auto& o) { o.right_wheel_names = o.left_wheel_names; }},
      {"right_wheel_names", "without a name", [](auto& o) { o.right_wheel_names = {""}; }},
      {"wheel_separation", "0 is not in", [](auto& o) { o.wheel_separation_m = 0; }},
      {"wheel_radius", "-0.033 is not in", [](auto& o) { o.wheel_radius_m = -0.033; }},
      {"wheel_radius", "nan is not in", [=](auto& o) { o.wheel_radius_m = nan; }},
      {"wheel_separation_multiplier", "0 is not in", [](auto& o) { o.wheel_separation_multiplier = 0; }},
      {"cmd_vel_timeout", "-1 is not in", [](auto& o) { o.cmd_vel_timeout_s = -1; }},
      {"update_rate", "0 is not in", [](auto& o) { o.update_rate_hz = 0; }},
      {"publish_rate", "5000 is not in", [](auto& o) { o.publish_rate_hz = 5000; }},
      {"linear.x.max_velocity", "-0.5 must be", [](auto& o) { o.linear.limits.max_velocity = -0.5; }},
      {"angular.z.max_deceleration", "1.5 must be", [](auto& o) { o.angular.limits.max_deceleration = 1.5; }},
      {"linear.x.max_jerk", "inf must be finite",
       [](auto& o) { o.linear.limits.max_jerk = std::numeric_limits<double>::infinity(); }},
      {"linear.x.min_acceleration", "2 must be", [](auto& o) { o.linear.min_acceleration = 2; }},
      {"hardware", "'wavshare'", [](auto& o) { o.hardware = "wavshare"; }},
      {"serial_port", "no path", [](auto& o) { o.serial_port.clear(); }},
      {"baud_rate", "115201", [](auto& o) { o.baud_rate = 115201; }},
      {"counts_per_turn", "not set", [](auto& o) { o.hardware = "roboclaw"; }},
      {"left_channel", "3", [](auto& o) { o.hardware = "roboclaw", o.counts_per_turn = 1440, o.left_channel = 3; }},
      {"right_channel", "channel 1",
       [](auto& o) { o.hardware = "roboclaw", o.counts_per_turn = 9, o.right_channel = 1; }},
      {"right_channel", "channel -1", [](auto& o) { o.hardware = "vesc", o.counts_per_turn = 90; }},
      {"right_channel", "300", [](auto& o) { o.hardware = "vesc", o.counts_per_turn = 90, o.right_channel = 300; }},
      {"can_interface", "no interface", [](auto& o) { o.hardware = "odrive_can", o.can_interface.clear(); }},
      {"left_channel", "63", [](auto& o) { o.hardware = "odrive_can", o.left_channel = 63; }},
      {"right_channel", "channel 1", [](auto& o) { o.hardware = "odrive_can", o.left_channel = 1; }},
      {"left_channel", "-1 is no channel", [](auto& o) { o.hardware = "vesc_can", o.counts_per_turn = 90; }},
      {"counts_per_turn", "not set",
       [](auto& o) { o.hardware = "vesc_can", o.left_channel = 7, o.right_channel = 42; }},
      {"left_channel", "0 is no channel", [](auto& o) { o.hardware = "hiwonder", o.left_channel = 0; }},
      {"right_channel", "5 is no channel", [](auto& o) { o.hardware = "hiwonder", o.right_channel = 5; }},
      {"board_address", "200", [](auto& o) { o.hardware = "roboclaw", o.counts_per_turn = 9, o.board_address = 200; }},
  };
  for (const Row& row : table) {
    DiffDriveOptions options;
    row.spoil(options);
    const auto setup = validated(options, "/robot/diff_drive");
    ASSERT_FALSE(setup) << row.parameter;
    EXPECT_THAT(setup.error().where.text(), HasSubstr("/robot/diff_drive"));
    EXPECT_THAT(setup.error().where.text(), HasSubstr(row.parameter));
    EXPECT_THAT(setup.error().what, HasSubstr(row.value));
    EXPECT_FALSE(setup.error().way_out.empty()) << row.parameter;
  }
}

TEST(DiffDriveOptions, suggests_the_hardware_that_was_meant) {
  DiffDriveOptions options;
  options.hardware = "wavshare";
  EXPECT_THAT(validated(options, "/d").error().way_out, HasSubstr("waveshare"));
}

TEST(DiffDriveOptions, a_loopback_needs_no_line) {
  DiffDriveOptions options;
  options.hardware = "loopback";
  options.serial_port.clear();
  EXPECT_TRUE(validated(options, "/d"));
}

TEST(DiffDriveOptions, warns_of_a_board_that_reports_no_wheels_and_has_no_watchdog) {
  DiffDriveOptions options;
  EXPECT_TRUE(validated(options, "/d").value().warnings.empty());
  options.hardware = "hiwonder";
  const auto setup = validated(options, "/d");
  ASSERT_TRUE(setup);
  ASSERT_EQ(setup.value().warnings.size(), 2U);
  EXPECT_THAT(setup.value().warnings[0], HasSubstr("open loop"));
  EXPECT_THAT(setup.value().warnings[1], HasSubstr("no watchdog"));
}

TEST(DiffDriveOptions, boards_on_can_need_no_serial_line_and_know_their_frames) {
  DiffDriveOptions options;
  options.hardware = "odrive_can";
  options.serial_port.clear();
  options.left_channel = 3;
  ASSERT_TRUE(validated(options, "/d"));
  EXPECT_EQ(line_of_board(options), "can0");
  constexpr std::uint32_t kExtended = 0x80000000, kRemote = 0x40000000;
  const auto passes = [&](std::uint32_t id) {
    const auto filters = filters_of_board(options);
    return std::ranges::any_of(filters,
                               [&](const auto& filter) { return (id & filter.mask) == (filter.id & filter.mask); });
  };
  EXPECT_TRUE(passes(0x061) && passes(0x069)) << "of node 3";
  EXPECT_TRUE(passes(0x021)) << "of node 1";
  EXPECT_FALSE(passes(0x041) || passes(0x069 | kRemote) || passes(0x069 | kExtended));

  options.hardware = "vesc_can";
  options.left_channel = 7;
  options.right_channel = 42;
  options.counts_per_turn = 90;
  ASSERT_TRUE(validated(options, "/d"));
  EXPECT_TRUE(passes(0x907 | kExtended) && passes(0x1B2A | kExtended)) << "status messages of both";
  EXPECT_TRUE(passes(0x8FE | kExtended)) << "answers to this host";
  EXPECT_FALSE(passes(0x908 | kExtended) || passes(0x107));
}

TEST(DiffDriveOptions, deprecated_switches_turn_limits_off_and_say_so) {
  DiffDriveOptions options;
  options.linear.limits.max_velocity = 1.0;
  options.linear.limits.max_acceleration = 2.0;
  options.linear.limits.max_jerk = 3.0;
  options.linear.has_velocity_limits = options.linear.has_acceleration_limits = options.linear.has_jerk_limits = false;
  const DriveSetup setup = validated(options, "/d").value();
  EXPECT_EQ(limited_speed(setup.loop.limits.linear, {}, 9.0, 0.02), 9.0);
  ASSERT_EQ(setup.warnings.size(), 3U);
  EXPECT_THAT(setup.warnings[0], HasSubstr("linear.x.has_velocity_limits"));
}

TEST(DiffDriveOptions, the_deprecated_min_acceleration_bounds_braking_whichever_way_the_base_moves) {
  DiffDriveOptions options;
  options.linear.limits.max_acceleration = 1.0;
  options.linear.min_acceleration = -2.0;
  const AxisLimits limits = validated(options, "/d").value().loop.limits.linear;
  EXPECT_NEAR(limited_speed(limits, {1, 1}, -9, 0.1), 0.8, 1e-12);
  EXPECT_NEAR(limited_speed(limits, {-1, -1}, -9, 0.1), -1.2, 1e-12);
  EXPECT_NEAR(limited_speed(limits, {-1, -1}, 9, 0.1), -0.9, 1e-12);
}

}  // namespace
}  // namespace nacelle::diff_drive
