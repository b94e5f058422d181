// SPDX-License-Identifier: Apache-2.0
#include "nacelle/description/ros2_control.hpp"

#include <gtest/gtest.h>

#include "nacelle/description/xacro.hpp"

namespace nacelle::description {
namespace {

// Eight lines of robot; what is appended begins in line 9.
const std::string kRobot =
    "<robot name=\"r\">\n"
    "<link name=\"base\"/><link name=\"l\"/><link name=\"r\"/><link name=\"mast\"/>\n"
    "<joint name=\"near\" type=\"continuous\"><parent link=\"base\"/><child link=\"l\"/>"
    "<origin xyz=\"0 0.15 0\"/></joint>\n"
    "<joint name=\"far\" type=\"continuous\"><parent link=\"base\"/><child link=\"r\"/>"
    "<origin xyz=\"0 -0.15 0\"/></joint>\n"
    "<joint name=\"mast_joint\" type=\"fixed\">\n"
    "<parent link=\"base\"/>\n"
    "<child link=\"mast\"/>\n"
    "</joint>\n";

std::string joint(const std::string& name, const std::string& inside = "<command_interface name=\"velocity\"/>") {
  return "<joint name=\"" + name + "\">" + inside + "</joint>\n";
}

std::string block(const std::string& inside, const std::string& type = "system") {
  return "<ros2_control name=\"wheels\" type=\"" + type + "\">\n<hardware><plugin> a/B </plugin></hardware>\n" +
         inside + "</ros2_control>\n";
}

ControlDescription read(const std::string& more) {
  return read_ros2_control({kRobot + more + "</robot>\n", "robot.urdf", {}});
}

std::vector<std::string> texts(const std::vector<Problem>& problems) {
  std::vector<std::string> all;
  for (const auto& problem : problems) all.push_back(problem.text());
  return all;
}
using Texts = std::vector<std::string>;

TEST(Ros2Control, reads_hardware_parameters_joints_and_interfaces_with_their_places) {
  const auto all = read(
      "<ros2_control name=\"wheels\" type=\"system\" rw_rate=\"100\">\n"
      "<hardware>\n"
      "<plugin>\n  nacelle/waveshare\n</plugin>\n"
      "<param name=\"device\">/dev/ttyACM0</param>\n"
      "</hardware>\n"
      "<joint name=\"near\">\n"
      "<command_interface name=\"velocity\"><param name=\"min\">-10</param></command_interface>\n"
      "<state_interface name=\"position\"/>\n"
      "<state_interface name=\"velocity\"/>\n"
      "</joint>\n"
      "</ros2_control>\n");
  EXPECT_EQ(texts(all.errors), Texts{});
  EXPECT_EQ(texts(all.warnings), Texts{});
  ASSERT_EQ(all.blocks.size(), 1U);
  const ControlBlock& wheels = all.blocks[0];
  EXPECT_EQ(wheels.name + " " + wheels.type + " " + wheels.where.text(), "wheels system robot.urdf:9");
  EXPECT_EQ(wheels.plugin + " " + wheels.plugin_where.text(), "nacelle/waveshare robot.urdf:11");
  ASSERT_EQ(wheels.params.size(), 1U);
  EXPECT_EQ(wheels.params[0].name + " " + wheels.params[0].value + " " + wheels.params[0].where.text(),
            "device /dev/ttyACM0 robot.urdf:14");
  ASSERT_EQ(wheels.joints.size(), 1U);
  EXPECT_TRUE(wheels.joints[0].has_command("velocity"));
  EXPECT_FALSE(wheels.joints[0].has_command("position"));
  ASSERT_EQ(wheels.joints[0].states.size(), 2U);
  EXPECT_EQ(wheels.joints[0].states[1].where.text(), "robot.urdf:19");
}

TEST(Ros2Control, reports_each_mistake_with_its_line_and_a_fix) {
  const auto errors = [](const std::string& more) { return texts(read(more).errors); };
  EXPECT_EQ(errors(block(joint("naer"))), Texts{"robot.urdf:11: the robot has no joint 'naer'; did you mean 'near'?"});
  EXPECT_EQ(errors(block(joint("mast_joint"))),
            Texts{"robot.urdf:11: joint 'mast_joint' is fixed (robot.urdf:5), and cannot be commanded; give it another "
                  "type, or take its command interfaces out"});
  EXPECT_EQ(errors(block(joint("mast_joint", "<state_interface name=\"position\"/>"))), Texts{});
  EXPECT_EQ(errors(block(joint("near", "<command_interface name=\"velosity\"/>"))),
            Texts{"robot.urdf:11: 'velosity' is not an interface; did you mean 'velocity'?"});
  EXPECT_EQ(errors(block(joint("near", "<command_interface name=\"lamp\"/>"))), Texts{}) << "a name of one's own";
  EXPECT_EQ(errors(block(joint("near", "<state_interface/>"))),
            Texts{"robot.urdf:11: <state_interface> has no name; add name=\"...\""});
  EXPECT_EQ(errors(block(joint("near") + joint("near"))),
            Texts{"robot.urdf:12: joint 'near' is twice in this block; take one of them out"});
  EXPECT_EQ(
      errors(block(joint("near", "<command_interface name=\"velocity\"/><command_interface name=\"velocity\"/>"))),
      Texts{"robot.urdf:11: joint 'near' has the command_interface 'velocity' twice; take one of them out"});
  EXPECT_EQ(errors(block("", "sistem")),
            Texts{"robot.urdf:9: 'sistem' is not a type of hardware; did you mean 'system'?"});
  EXPECT_EQ(errors("<ros2_control name=\"w\" type=\"system\"/>"),
            Texts{"robot.urdf:9: <ros2_control name=\"w\"> names no hardware plugin; add "
                  "<hardware><plugin>nacelle/waveshare</plugin></hardware>"});
}

TEST(Ros2Control, wheels_are_as_far_apart_as_their_joints_and_as_large_as_their_links) {
  const Wheels wheels{{"near"}, {"far"}};
  const auto joints_only = wheel_lengths_of(read(block(joint("near") + joint("far"))), wheels);
  EXPECT_DOUBLE_EQ(joints_only.separation_m.value(), 0.3);
  EXPECT_FALSE(joints_only.radius_m) << "the links have no shape";
  EXPECT_FALSE(wheel_lengths_of(read(""), {{"mast_joint"}, {"mast_joint"}}).separation_m) << "one place is no distance";
  const std::string given =
      "<ros2_control name=\"w\" type=\"system\"><hardware><plugin>a/B</plugin><param "
      "name=\"wheel_separation\">0.28</param>"
      "<param name=\"wheel_radius\">0.04</param></hardware>" +
      joint("near") + joint("far") + "</ros2_control>";
  EXPECT_DOUBLE_EQ(wheel_lengths_of(read(given), wheels).separation_m.value(), 0.28);
  EXPECT_DOUBLE_EQ(wheel_lengths_of(read(given), wheels).radius_m.value(), 0.04);
}

TEST(Ros2Control, unknown_tags_are_a_warning) {
  const auto all = read(block(joint("near", "<command_interfaces name=\"velocity\"/>") +
                              "<controller name=\"c\"/>\n<sensor name=\"imu\">"
                              "<what_a_sensor_has/></sensor>\n"));
  EXPECT_EQ(texts(all.errors), Texts{});
  EXPECT_EQ(
      texts(all.warnings),
      (Texts{"robot.urdf:12: <controller> is not a tag of ros2_control inside <ros2_control>, and is ignored; a "
             "controller's parameters belong into the parameter file: `nacelle import`",
             "robot.urdf:11: <command_interfaces> is not a tag of ros2_control inside <joint>, and is ignored; did "
             "you mean 'command_interface'?"}));
}

TEST(Ros2Control, a_robot_without_a_block_and_a_text_that_is_no_xml_have_none) {
  EXPECT_TRUE(read("").blocks.empty());
  EXPECT_EQ(read("").joints.size(), 3U);
  EXPECT_TRUE(read_ros2_control({"<robot", "robot.urdf", {}}).joints.empty());
  EXPECT_TRUE(read_ros2_control({"", "", {}}).joints.empty());
}

TEST(Ros2Control, the_left_wheel_is_the_one_of_positive_y_whatever_its_name) {
  const auto wheels = wheels_of(read(block(joint("far") + joint("near"))));
  ASSERT_TRUE(wheels) << wheels.error().text();
  EXPECT_EQ(wheels->left, std::vector<std::string>{"near"});
  EXPECT_EQ(wheels->right, std::vector<std::string>{"far"});
}

TEST(Ros2Control, the_side_follows_the_joints_above) {
  // The axle is turned by half a turn: what lies at its +y is on the robot's right.
  const auto wheels =
      wheels_of(read_ros2_control({"<robot name=\"r\">"
                                   "<joint name=\"axle\" type=\"fixed\"><parent link=\"base\"/><child link=\"axle\"/>"
                                   "<origin xyz=\"0 0.1 0\" rpy=\"0 0 3.14159265\"/></joint>"
                                   "<joint name=\"a\" type=\"continuous\"><parent link=\"axle\"/><child link=\"w\"/>"
                                   "<origin xyz=\"0 0.3 0\"/></joint>" +
                                       block(joint("a")) + "</robot>",
                                   "robot.urdf",
                                   {}}));
  ASSERT_TRUE(wheels);
  EXPECT_EQ(wheels->right, std::vector<std::string>{"a"});
}

TEST(Ros2Control, uses_the_name_if_y_is_zero_and_otherwise_reports_the_wheel) {
  const auto with = [](const std::string& name) {
    return wheels_of(read_ros2_control({"<robot name=\"r\">\n<joint name=\"" + name +
                                            "\" type=\"continuous\"><parent link=\"b\"/><child link=\"w\"/></joint>\n" +
                                            block(joint(name)) + "</robot>",
                                        "robot.urdf",
                                        {}}));
  };
  EXPECT_EQ(with("rear_left").value().left, std::vector<std::string>{"rear_left"});
  ASSERT_FALSE(with("middle"));
  EXPECT_EQ(with("middle").error().text(),
            "robot.urdf:5: joint 'middle' may be a wheel of the left or of the right: its y is 0; set left_wheel_names "
            "and right_wheel_names");
}

TEST(Ros2Control, joints_in_a_circle_end) {
  const auto all = read_ros2_control(
      {"<robot name=\"r\"><joint name=\"a\" type=\"continuous\"><parent link=\"x\"/><child link=\"y\"/></joint>"
       "<joint name=\"b\" type=\"continuous\"><parent link=\"y\"/><child link=\"x\"/></joint></robot>",
       "robot.urdf",
       {}});
  EXPECT_EQ(all.y_of(all.joints[0]), std::nullopt);
}

TEST(Ros2Control, places_are_the_lines_of_the_xacro_files_also_through_macros_and_blocks) {
  XacroEnvironment environment;
  environment.read_file = [](const std::string& path) -> Result<std::string, Problem> {
    if (path == "/r/wheel.xacro")
      return std::string{
          "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n"
          "<xacro:macro name=\"wheel\" params=\"name *interfaces\">\n"
          "<joint name=\"${name}\">\n"
          "<xacro:insert_block name=\"interfaces\"/>\n"
          "</joint>\n"
          "</xacro:macro>\n</robot>"};
    return std::string{
        "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n"
        "<xacro:include filename=\"/r/wheel.xacro\"/>\n"
        "<ros2_control name=\"wheels\" type=\"system\">\n"
        "<hardware><plugin>a/B</plugin></hardware>\n"
        "<xacro:wheel name=\"nowhere\">\n"
        "<command_interface name=\"velosity\"/>\n"
        "</xacro:wheel>\n"
        "</ros2_control>\n</robot>"};
  };
  auto expanded = expand_xacro("/r/robot.xacro", {}, environment);
  ASSERT_TRUE(expanded) << expanded.error().text();
  const auto all = read_ros2_control({expanded->urdf, "/r/robot.xacro", expanded->places});
  EXPECT_EQ(texts(all.errors), (Texts{"/r/robot.xacro:6: 'velosity' is not an interface; did you mean 'velocity'?",
                                      "/r/wheel.xacro:3: the robot has no joint 'nowhere'"}));
}

}  // namespace
}  // namespace nacelle::description
