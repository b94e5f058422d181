// SPDX-License-Identifier: Apache-2.0
#include "text/message_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <geometry_msgs/msg/twist_stamped.hpp>
#include <limits>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/byte.hpp>
#include <std_msgs/msg/empty.hpp>
#include <std_msgs/msg/string.hpp>
#include <std_msgs/msg/u_int64.hpp>

#include "nacelle/msgs/json.hpp"

namespace nacelle::text {
namespace {

using geometry_msgs::msg::TwistStamped;
using msgs::MessageFault;
using sensor_msgs::msg::JointState;
using ::testing::HasSubstr;

constexpr WallTime kNow{Duration{5'000'000'007}};

/// The message, or a test that fails and says why.
template <typename T>
T read(std::string_view text) {
  T message;
  auto json = read_message_text(text, T::message_type(), kNow);
  EXPECT_TRUE(json) << (json ? "" : json.error().text());
  if (!json) return message;
  auto done = msgs::from_json(json.value().json, T::message_type(), &message);
  EXPECT_TRUE(done) << (done ? "" : done.error().text());
  return message;
}

/// What is wrong with the text, by whichever of the two readers finds it.
template <typename T>
Problem problem_of(std::string_view text) {
  T message;
  auto json = read_message_text(text, T::message_type(), kNow);
  if (!json) return json.error();
  auto done = msgs::from_json(json.value().json, T::message_type(), &message);
  return done ? Problem{} : done.error();
}

/// The text is refused with this code; `where` is its line or the path of the field, `value` what stands there.
template <typename T>
void expect_refusal(std::string_view text, MessageFault code, const std::string& where, const std::string& value) {
  const Problem problem = problem_of<T>(text);
  EXPECT_EQ(problem.code.text(), code_text(code)) << problem.text();
  EXPECT_EQ(problem.where.text(), where) << problem.text();
  EXPECT_EQ(problem.value, value) << problem.text();
}

TEST(MessageText, reads_yaml_as_ros2_topic_pub_does) {
  const auto command =
      read<TwistStamped>("{header: {frame_id: base}, twist: {linear: {x: 0.5, y: -1}, angular: {z: .nan}}}");
  EXPECT_EQ(command.header.frame_id, "base");
  EXPECT_EQ(command.twist.linear.x, 0.5);
  EXPECT_EQ(command.twist.linear.y, -1.0);
  EXPECT_TRUE(std::isnan(command.twist.angular.z));
  const auto joints = read<JointState>("name: [left, 'right']\nposition:\n- 1\n- -.inf\nvelocity: []\n");
  EXPECT_EQ(joints.name.size(), 2U);
  EXPECT_EQ(joints.name[1], "right");
  EXPECT_EQ(joints.position[1], -std::numeric_limits<double>::infinity());
}

TEST(MessageText, the_field_decides_what_a_scalar_is) {
  EXPECT_EQ(read<std_msgs::msg::String>("data: 5").data, "5");
  EXPECT_EQ(read<std_msgs::msg::String>("{data: yes}").data, "yes");
  EXPECT_EQ(read<std_msgs::msg::String>("data: Hello World").data, "Hello World");
  EXPECT_EQ(read<std_msgs::msg::UInt64>("data: 18446744073709551615").data, std::numeric_limits<std::uint64_t>::max());
  expect_refusal<std_msgs::msg::UInt64>("data: -1", MessageFault::OutOfRange, "data", "-1");
  expect_refusal<std_msgs::msg::UInt64>("data: many", MessageFault::WrongType, "data", "\"many\"");
}

TEST(MessageText, json_is_read_as_json) {
  EXPECT_EQ(read<std_msgs::msg::String>(R"({"data": "\u0041\ud83d\ude00"})").data, "A\xF0\x9F\x98\x80");
  EXPECT_EQ(read<TwistStamped>(R"({"twist": {"linear": {"x": 0.25}}})").twist.linear.x, 0.25);
}

TEST(MessageText, nothing_is_a_message_of_defaults) {
  EXPECT_EQ(read<std_msgs::msg::String>("").data, "");
  EXPECT_EQ(read<std_msgs::msg::String>("{}").data, "");
  EXPECT_EQ(problem_of<std_msgs::msg::Empty>("{}"), Problem{});
}

TEST(MessageText, auto_and_now_are_the_time) {
  const auto text = read_message_text("header: auto", TwistStamped::message_type(), kNow);
  ASSERT_TRUE(text);
  EXPECT_TRUE(text.value().has_stamps);
  const auto command = read<TwistStamped>("header: auto");
  EXPECT_EQ(command.header.stamp.sec, 5);
  EXPECT_EQ(command.header.stamp.nanosec, 7U);
  EXPECT_EQ(read<TwistStamped>("header: {stamp: now, frame_id: auto}").header.frame_id, "auto");
  EXPECT_FALSE(read_message_text("header: {frame_id: now}", TwistStamped::message_type(), kNow).value().has_stamps);
}

TEST(MessageText, what_does_not_fit_is_named_with_its_place) {
  using enum MessageFault;
  expect_refusal<TwistStamped>("{twist: {linaer: {}}}", UnknownField, "twist.linaer", "linaer");
  expect_refusal<TwistStamped>("{twist: 5}", WrongType, "twist", "5");
  expect_refusal<TwistStamped>("{twist: {linear: {x: fast}}}", WrongType, "twist.linear.x", "\"fast\"");
  expect_refusal<JointState>("{position: 1}", WrongType, "position", "1");
  expect_refusal<JointState>("{position: [[1]]}", WrongType, "position[0]", "");
  expect_refusal<TwistStamped>("{twist: {}, twist: {}}", Twice, "twist", "twist");
  expect_refusal<TwistStamped>("{twist: \"x", Malformed, "the message:1", "");
  expect_refusal<TwistStamped>("- 1", WrongType, "the message:1", "");
  expect_refusal<TwistStamped>("fast", WrongType, "the message:1", "fast");
}

TEST(MessageText, a_refusal_shows_how_a_message_is_written) {
  EXPECT_EQ(problem_of<TwistStamped>("fast").text(),
            "the message:1: is text, not a map of geometry_msgs/msg/TwistStamped; write {header: ..., twist: ...}, see "
            "`nacelle interface show geometry_msgs/msg/TwistStamped`");
  EXPECT_THAT(problem_of<TwistStamped>("{twist: {linaer: {}}}").way_out, HasSubstr("did you mean 'linear'"));
  EXPECT_THAT(problem_of<TwistStamped>("{twist: {}, twist: {}}").text(), HasSubstr("twist: is given twice"));
  EXPECT_THAT(problem_of<TwistStamped>("{twist: {").text(), HasSubstr("(column 1); write {header: ..."));
}

TEST(MessageText, a_message_is_shown_as_python_shows_it) {
  TwistStamped command;
  command.header.frame_id = "it's";
  command.twist.linear.x = 0.1;
  std::string text;
  append_repr(text, TwistStamped::message_type(), &command);
  EXPECT_EQ(
      text,
      "geometry_msgs.msg.TwistStamped(header=std_msgs.msg.Header(stamp=builtin_interfaces.msg.Time(sec=0, nanosec=0), "
      "frame_id=\"it's\"), twist=geometry_msgs.msg.Twist(linear=geometry_msgs.msg.Vector3(x=0.1, y=0.0, z=0.0), "
      "angular=geometry_msgs.msg.Vector3(x=0.0, y=0.0, z=0.0)))");
  JointState joints;
  joints.name = {"a\n"};
  joints.position = {1.0, std::numeric_limits<double>::quiet_NaN()};
  text.clear();
  append_repr(text, JointState::message_type(), &joints);
  EXPECT_THAT(text, HasSubstr("name=['a\\n'], position=[1.0, nan], velocity=[]"));
  std_msgs::msg::Byte byte;
  byte.data = 7;
  text.clear();
  append_repr(text, std_msgs::msg::Byte::message_type(), &byte);
  EXPECT_EQ(text, "std_msgs.msg.Byte(data=b'\\x07')");
}

}  // namespace
}  // namespace nacelle::text
