// SPDX-License-Identifier: Apache-2.0
// What the commands read and write: answers, joint states, parameters.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/parameter_lines.hpp"
#include "calibration_commands/umbmark_calibration.hpp"
#include "calibration_commands/wheel_reading.hpp"
#include "nacelle/launch/parameter_file.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

ParametersOf parameters_of_a_base() {
  return {{"hardware", "waveshare"},
          {"left_wheel_names", {"l1", "l2"}},
          {"right_wheel_names", {"r1", "r2"}},
          {"wheel_radius", 0.033},
          {"wheel_separation", 0.3},
          {"left_wheel_radius_multiplier", 1.1},
          {"right_wheel_radius_multiplier", 1.2},
          {"wheel_separation_multiplier", 0.9},
          {"cmd_vel_timeout", 0.5},
          {"topics.slow.topic", "/robot/cmd_slow"},
          {"topics.slow.timeout", 2.0}};
}

TEST(Answer, is_a_number_above_zero) {
  EXPECT_EQ(positive_number_in("1.97"), 1.97);
  EXPECT_EQ(positive_number_in("  2 "), 2.0);
  EXPECT_EQ(positive_number_in("1.97 m"), 1.97);
  for (const char* const wrong : {"", " ", "m", "1,97", "-1", "0", "nan", "inf", "1.9.7", "1e999"})
    EXPECT_EQ(positive_number_in(wrong), 0.0) << wrong;
}

TEST(BaseParameters, are_those_of_the_node) {
  const auto base = base_parameters(parameters_of_a_base(), "/robot/diff_drive", "/robot/cmd_vel");
  ASSERT_TRUE(base);
  EXPECT_DOUBLE_EQ(base->geometry.left_radius_m(), 0.033 * 1.1);
  EXPECT_DOUBLE_EQ(base->geometry.right_radius_m(), 0.033 * 1.2);
  EXPECT_DOUBLE_EQ(base->geometry.separation_m(), 0.27);
  EXPECT_EQ(base->command_timeout, 500ms);
  const auto slow = base_parameters(parameters_of_a_base(), "/robot/diff_drive", "/robot/cmd_slow");
  ASSERT_TRUE(slow);
  EXPECT_EQ(slow->command_timeout, 2s);
}

TEST(BaseParameters, of_another_node_are_refused) {
  for (const char* const missing : {"hardware", "wheel_radius", "left_wheel_names", "wheel_separation_multiplier"}) {
    auto parameters = parameters_of_a_base();
    parameters.erase(missing);
    const auto base = base_parameters(parameters, "/odometry", "/cmd_vel");
    ASSERT_FALSE(base) << missing;
    EXPECT_EQ(base.error().where.text(), "/odometry");
  }
}

TEST(WheelReading, is_the_mean_of_each_side) {
  const auto base = base_parameters(parameters_of_a_base(), "/base", "/cmd_vel");
  ASSERT_TRUE(base);
  const json message{{"name", {"arm", "r2", "l1", "r1", "l2"}}, {"position", {9.0, 4.0, 1.0, 2.0, 2.0}}};
  const auto wheels = wheels_in(message, *base);
  ASSERT_TRUE(wheels);
  EXPECT_DOUBLE_EQ(wheels->left_rad, 1.5);
  EXPECT_DOUBLE_EQ(wheels->right_rad, 3.0);
}

TEST(WheelReading, is_nothing_without_all_wheels) {
  const auto base = base_parameters(parameters_of_a_base(), "/base", "/cmd_vel");
  ASSERT_TRUE(base);
  for (const json& message : {json::object(), json{{"name", {"arm"}}, {"position", {1.0}}},
                              json{{"name", {"l1", "l2", "r1", "r2"}}, {"position", {1.0, 1.0, 1.0}}},
                              json{{"name", {"l1", "l2", "r1", "r2"}}, {"position", {1.0, 1.0, 1.0, "NaN"}}},
                              json{{"name", 1}, {"position", 2}}})
    EXPECT_FALSE(wheels_in(message, *base)) << message;
}

TEST(ParameterLines, read_back_as_doubles) {
  const std::array<double, 3> values{1.0, -2.5e-7, 0.0};
  const std::string text =
      parameter_file("/robot/imu", {"why"}, {parameter_line("one", 1.0), parameter_line("list", values)});
  EXPECT_EQ(text,
            "# why\n/robot/imu:\n  ros__parameters:\n    one: 1.00000000\n"
            "    list: [1.00000000, -2.50000000e-07, 0.00000000]\n");
  const auto file = launch::parse_parameter_file(text, "calibration.yaml");
  ASSERT_TRUE(file);
  const auto read = file->parameters_for("/robot/imu");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].value, ParameterValue{1.0});
  EXPECT_EQ(read[1].value, (ParameterValue{std::vector<double>{1.0, -2.5e-7, 0.0}}));
}

TEST(ParameterLines, values_of_another_type_do_not_count) {
  const ParametersOf parameters{{"text", "a"}, {"mixed", {1.0, "NaN"}}, {"short", {1.0}}, {"good", {1.0, 2.0}}};
  const std::array<double, 2> otherwise{7.0, 8.0};
  for (const char* const name : {"text", "mixed", "short", "none"})
    EXPECT_EQ(list_in<2>(parameters, name, otherwise), otherwise) << name;
  EXPECT_EQ(list_in<2>(parameters, "good", otherwise), (std::array<double, 2>{1.0, 2.0}));
  EXPECT_EQ(number_in(parameters, "text", 3.0), 3.0);
}

TEST(Topic, beside_a_node_is_in_its_namespace) {
  EXPECT_EQ(beside("/imu", "imu/mag"), "/imu/mag");
  EXPECT_EQ(beside("/robot/imu", "imu/mag"), "/robot/imu/mag");
  EXPECT_EQ(beside("/robot/imu", "/mag"), "/mag");
}

TEST(Answer, may_be_any_number) {
  EXPECT_EQ(number_in_answer("-0.03 m"), -0.03);
  EXPECT_EQ(number_in_answer("0"), 0.0);
  for (const char* const wrong : {"", " ", "m", "1,97", "nan", "-inf", "--1"})
    EXPECT_FALSE(number_in_answer(wrong)) << wrong;
}

TEST(Answer, to_where_a_square_ended_is_two_numbers) {
  EXPECT_EQ(wrong_end("0.03,-0.12"), "");
  EXPECT_EQ(wrong_end("0,0"), "");
  for (const char* const wrong : {"", "0.1", "0.1;0.2", "0.1,", ",0.1", "0.1,a", "1,2,3"})
    EXPECT_NE(wrong_end(wrong), "") << wrong;
}

TEST(WheelReading, has_the_stamp_of_its_message) {
  const auto base = base_parameters(parameters_of_a_base(), "/base", "/cmd_vel");
  ASSERT_TRUE(base);
  json message{{"name", {"l1", "l2", "r1", "r2"}}, {"position", {1.0, 1.0, 2.0, 2.0}}};
  EXPECT_FALSE(sample_in(message, *base)) << "without a header";
  message["header"]["stamp"] = {{"sec", 12}, {"nanosec", 500000000}};
  const auto sample = sample_in(message, *base);
  ASSERT_TRUE(sample);
  EXPECT_DOUBLE_EQ(sample->stamp_s, 12.5);
  EXPECT_DOUBLE_EQ(sample->turn.right_rad, 2.0);
}

}  // namespace
}  // namespace nacelle::cli
