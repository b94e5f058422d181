// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/described_base.hpp"

#include <gtest/gtest.h>

#include "diff_drive/component/diff_drive_component.hpp"
#include "support/recording_host.hpp"

namespace nacelle::diff_drive {
namespace {

using Texts = std::vector<std::string>;
const std::string kInterfaces =
    "<command_interface name=\"velocity\"/><state_interface name=\"position\"/><state_interface name=\"velocity\"/>";

struct Robot {
  std::string plugin = "nacelle/waveshare", params, left_type = "continuous", left_interfaces = kInterfaces;

  [[nodiscard]] std::string urdf() const {
    return "<robot name=\"r\">\n"
           "<link name=\"base\"/><link name=\"l\"/><link name=\"r\"/>\n"
           "<joint name=\"drivewhl_l\" type=\"" +
           left_type +
           "\"><parent link=\"base\"/><child link=\"l\"/>"
           "<origin xyz=\"0 0.2 0\"/></joint>\n"
           "<joint name=\"drivewhl_r\" type=\"continuous\"><parent link=\"base\"/><child link=\"r\"/>"
           "<origin xyz=\"0 -0.2 0\"/></joint>\n"
           "<ros2_control name=\"wheels\" type=\"system\">\n<hardware><plugin>" +
           plugin + "</plugin>\n" + params + "</hardware>\n<joint name=\"drivewhl_l\">" + left_interfaces +
           "</joint>\n<joint name=\"drivewhl_r\">" + kInterfaces + "</joint>\n</ros2_control>\n</robot>\n";
  }
  [[nodiscard]] DescribedBase read(const GivenNames& given = {}) const {
    return described_base(description::read_ros2_control({urdf(), "robot.urdf", {}}), given);
  }
};

Texts texts(const std::vector<Problem>& problems) {
  Texts all;
  for (const auto& problem : problems) all.push_back(problem.text());
  return all;
}

TEST(DescribedBase, has_the_wheels_of_the_block) {
  const auto base = Robot{}.read();
  EXPECT_EQ(texts(base.problems), Texts{});
  EXPECT_EQ(texts(base.warnings), Texts{});
  EXPECT_EQ(base.defaults.left_wheel_names, Texts{"drivewhl_l"});
  EXPECT_EQ(base.defaults.right_wheel_names, Texts{"drivewhl_r"});
  EXPECT_EQ(base.defaults.hardware, "waveshare");
}

TEST(DescribedBase, has_every_wheel_of_a_side) {
  std::string links, joints, block;
  const auto add = [&](const std::string& name, const char* at) {
    links += "<link name=\"" + name + "_link\"/>";
    joints += "<joint name=\"" + name + "\" type=\"continuous\"><parent link=\"base\"/><child link=\"" + name +
              "_link\"/><origin xyz=\"" + at + "\"/></joint>";
    block += "<joint name=\"" + name + "\">" + kInterfaces + "</joint>";
  };
  add("front_left", "0.15 0.2 0");
  add("front_right", "0.15 -0.2 0");
  add("rear_left", "-0.15 0.25 0");
  add("rear_right", "-0.15 -0.25 0");
  const std::string urdf = "<robot name=\"r\"><link name=\"base\"/>" + links + joints +
                           "<ros2_control name=\"wheels\" type=\"system\"><hardware><plugin>nacelle/waveshare</plugin>"
                           "</hardware>" +
                           block + "</ros2_control></robot>";
  const auto base = described_base(description::read_ros2_control({urdf, "robot.urdf", {}}), {});
  EXPECT_EQ(texts(base.problems), Texts{});
  EXPECT_EQ(texts(base.warnings), Texts{});
  EXPECT_EQ(base.defaults.left_wheel_names, (Texts{"front_left", "rear_left"}));
  EXPECT_EQ(base.defaults.right_wheel_names, (Texts{"front_right", "rear_right"}));
  EXPECT_NEAR(base.defaults.wheel_separation_m, 0.45, 1e-12) << "between the means of the sides";

  const auto with_a_wrong_one = described_base(description::read_ros2_control({urdf, "robot.urdf", {}}),
                                               {.left_wheels = Texts{"front_left", "rear_letf"},
                                                .right_wheels = Texts{"front_right", "rear_right"},
                                                .hardware = {}});
  EXPECT_EQ(
      texts(with_a_wrong_one.problems),
      Texts{"parameter left_wheel_names: left_wheel_names holds 'rear_letf', and the robot has no such joint; did "
            "you mean 'rear_left'?"});
}

TEST(DescribedBase, reads_parameters_by_the_names_of_ros2_controls_drivers_and_by_ours) {
  const auto base = Robot{.plugin = "mock_components/GenericSystem",
                          .params =
                              "<param name=\"device\">/dev/ttyACM3</param><param name=\"baud_rate\">57600</param>"
                              "<param name=\"timeout_ms\">250</param><param name=\"loop_rate\">30</param>"
                              "<param name=\"wheel_radius\">0.05</param>"
                              "<param name=\"left_wheel_name\">drivewhl_l</param>"}
                        .read();
  EXPECT_EQ(texts(base.problems), Texts{});
  EXPECT_EQ(texts(base.warnings), Texts{});
  EXPECT_EQ(base.defaults.hardware, "loopback");
  EXPECT_EQ(base.defaults.serial_port, "/dev/ttyACM3");
  EXPECT_EQ(base.defaults.baud_rate, 57600);
  EXPECT_DOUBLE_EQ(base.defaults.port_timeout_s, 0.25);
  EXPECT_DOUBLE_EQ(base.defaults.update_rate_hz, 30.0);
  EXPECT_DOUBLE_EQ(base.defaults.wheel_radius_m, 0.05);
}

TEST(DescribedBase, warns_about_unused_settings) {
  const auto base = Robot{.plugin = "gz_ros2_control/GazeboSimSystem",
                          .params = "<param name=\"pid_p\">20</param>\n<param name=\"weel_radius\">1</param>"}
                        .read();
  EXPECT_EQ(texts(base.problems), Texts{});
  EXPECT_EQ(
      texts(base.warnings),
      (Texts{"robot.urdf:6: the hardware plugin 'gz_ros2_control/GazeboSimSystem' is not run here; the base drives "
             "a waveshare board; say nacelle/waveshare, nacelle/roboclaw, nacelle/vesc, nacelle/odrive, "
             "nacelle/odrive_can, nacelle/vesc_can, nacelle/hiwonder, nacelle/framed, nacelle/text, "
             "nacelle/pwm or nacelle/loopback, or set the parameter "
             "hardware",
             "robot.urdf:7: the base has no use for the parameter 'pid_p'; encoders and their control "
             "are the motor board's own matter",
             "robot.urdf:8: the base has no use for the parameter 'weel_radius'; did you mean 'wheel_radius'?"}));
  EXPECT_TRUE(
      (Robot{.plugin = "my/Own"}.read({.left_wheels = {}, .right_wheels = {}, .hardware = true}).warnings.empty()));
}

TEST(DescribedBase, takes_the_wiring_of_a_board_with_channels) {
  const auto base = Robot{.plugin = "roboclaw/RoboClawSystem",
                          .params =
                              "<param name=\"enc_counts_per_rev\">1440</param>\n"
                              "<param name=\"left_channel\">2</param>\n<param name=\"right_channel\">1</param>\n"
                              "<param name=\"left_reversed\">true</param>\n"
                              "<param name=\"board_address\">129</param>"}
                        .read();
  EXPECT_EQ(texts(base.problems), Texts{});
  EXPECT_EQ(base.defaults.hardware, "roboclaw");
  EXPECT_EQ(base.defaults.counts_per_turn, 1440.0);
  EXPECT_EQ(base.defaults.left_channel, 2);
  EXPECT_EQ(base.defaults.right_channel, 1);
  EXPECT_TRUE(base.defaults.left_reversed);
  EXPECT_FALSE(base.defaults.right_reversed);
  EXPECT_EQ(base.defaults.board_address, 129);
}

TEST(DescribedBase, knows_a_hiwonder_board) {
  EXPECT_EQ(Robot{.plugin = "nacelle/hiwonder"}.read().defaults.hardware, "hiwonder");
}

TEST(DescribedBase, takes_the_bus_of_odrives_own_plugin_and_of_ours) {
  const auto theirs = Robot{.plugin = "odrive_ros2_control_plugin/ODriveHardwareInterface",
                            .params = "<param name=\"can\">can1</param>"}
                          .read();
  EXPECT_EQ(texts(theirs.problems), Texts{});
  EXPECT_EQ(texts(theirs.warnings), Texts{});
  EXPECT_EQ(theirs.defaults.hardware, "odrive_can");
  EXPECT_EQ(theirs.defaults.can_interface, "can1");
  const auto ours = Robot{.plugin = "nacelle/vesc_can", .params = "<param name=\"can_interface\">can2</param>"}.read();
  EXPECT_EQ(ours.defaults.hardware, "vesc_can");
  EXPECT_EQ(ours.defaults.can_interface, "can2");
  EXPECT_EQ(Robot{.plugin = "nacelle/odrive"}.read().defaults.hardware, "odrive") << "the one on a serial line";
}

TEST(DescribedBase, tells_what_does_not_fit) {
  EXPECT_EQ(texts(Robot{.params = "<param name=\"left_reversed\">yes</param>"}.read().problems),
            Texts{"robot.urdf:7: 'yes' is neither true nor false, for the parameter 'left_reversed'"});
  EXPECT_EQ(texts(Robot{.params = "<param name=\"baud_rate\">fast</param>"}.read().problems),
            Texts{"robot.urdf:7: 'fast' is not a whole number, for the parameter 'baud_rate'"});
  EXPECT_EQ(
      texts(Robot{.params = "<param name=\"left_wheel_name\">drivewhl_left</param>"}.read().problems),
      Texts{"robot.urdf:7: left_wheel_name names 'drivewhl_left', which no <joint> with a velocity command is; did "
            "you mean 'drivewhl_l'?"});
  const GivenNames both{.left_wheels = Texts{"drivewhl_l"}, .right_wheels = Texts{"drivewhl_r"}};
  EXPECT_EQ(texts(Robot{.left_type = "revolute"}.read(both).problems),
            Texts{"robot.urdf:3: joint 'drivewhl_l' is a wheel (left_wheel_names), and its type is 'revolute'; a wheel "
                  "turns without end: type=\"continuous\""});
  EXPECT_EQ(texts(Robot{.left_interfaces = "<command_interface name=\"position\"/>"}.read(both).problems),
            Texts{"robot.urdf:8: the wheel 'drivewhl_l' has no velocity command; add <command_interface "
                  "name=\"velocity\"/>"});
  EXPECT_EQ(
      texts(Robot{}.read({.left_wheels = Texts{"drivewhl_x"}, .right_wheels = Texts{"drivewhl_r"}}).problems),
      Texts{"parameter left_wheel_names: left_wheel_names holds 'drivewhl_x', and the robot has no such joint; did "
            "you mean 'drivewhl_l'?"});
}

TEST(DescribedBase, a_state_that_the_base_does_not_measure_is_a_warning) {
  const auto base = Robot{.left_interfaces = kInterfaces + "<state_interface name=\"effort\"/>"}.read();
  EXPECT_EQ(texts(base.problems), Texts{});
  EXPECT_EQ(
      texts(base.warnings),
      Texts{"robot.urdf:8: the base does not measure the effort of 'drivewhl_l'; it measures position and velocity"});
}

TEST(DescribedBase, parameters_that_are_given_stand_above_it) {
  test::RecordingContext context;
  const Robot robot{.params = "<param name=\"device\">/dev/ttyACM3</param><param name=\"baud_rate\">57600</param>"};
  NodeOptions options{context};
  options.append_parameter_override("robot_description", robot.urdf());
  options.append_parameter_override("baud_rate", std::int64_t{9600});
  const DiffDriveComponent drive{options};
  EXPECT_EQ(drive.get<std::string>("serial_port"), "/dev/ttyACM3");
  EXPECT_EQ(drive.get<std::int64_t>("baud_rate"), 9600);
  EXPECT_EQ(drive.get<Texts>("left_wheel_names"), Texts{"drivewhl_l"});
}

TEST(DescribedBase, a_base_that_does_not_fit_its_description_is_not_configured) {
  test::RecordingContext context;
  NodeOptions options{context};
  options.append_parameter_override("robot_description", Robot{.params = "<param name=\"baud_rate\">x</param>"}.urdf());
  options.append_parameter_override("hardware", std::string{"loopback"});
  DiffDriveComponent drive{options};
  const auto outcome = drive.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.reason, "robot_description:7: 'x' is not a whole number, for the parameter 'baud_rate'");
}

TEST(DescribedBase, without_a_description_the_base_has_its_own_defaults) {
  test::RecordingContext context;
  const DiffDriveComponent drive{NodeOptions{context}};
  EXPECT_EQ(drive.get<Texts>("left_wheel_names"), Texts{"left_wheel_joint"});
}

}  // namespace
}  // namespace nacelle::diff_drive
