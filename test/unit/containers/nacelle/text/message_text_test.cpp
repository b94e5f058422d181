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
std::string complaint(std::string_view text) {
  T message;
  auto json = read_message_text(text, T::message_type(), kNow);
  if (!json) return json.error().text();
  auto done = msgs::from_json(json.value().json, T::message_type(), &message);
  return done ? "" : done.error().text();
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
  EXPECT_THAT(complaint<std_msgs::msg::UInt64>("data: -1"), HasSubstr("whole number from 0"));
  EXPECT_THAT(complaint<std_msgs::msg::UInt64>("data: many"), HasSubstr("data"));
}

TEST(MessageText, json_is_read_as_json) {
  EXPECT_EQ(read<std_msgs::msg::String>(R"({"data": "\u0041\ud83d\ude00"})").data, "A\xF0\x9F\x98\x80");
  EXPECT_EQ(read<TwistStamped>(R"({"twist": {"linear": {"x": 0.25}}})").twist.linear.x, 0.25);
}

TEST(MessageText, nothing_is_a_message_of_defaults) {
  EXPECT_EQ(read<std_msgs::msg::String>("").data, "");
  EXPECT_EQ(read<std_msgs::msg::String>("{}").data, "");
  EXPECT_EQ(complaint<std_msgs::msg::Empty>("{}"), "");
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
  EXPECT_THAT(complaint<TwistStamped>("{twist: {linaer: {}}}"), HasSubstr("did you mean 'linear'"));
  EXPECT_THAT(complaint<TwistStamped>("{twist: 5}"), HasSubstr("twist"));
  EXPECT_THAT(complaint<TwistStamped>("{twist: {linear: {x: fast}}}"), HasSubstr("twist.linear.x"));
  EXPECT_THAT(complaint<JointState>("{position: 1}"), HasSubstr("not a list"));
  EXPECT_THAT(complaint<JointState>("{position: [[1]]}"), HasSubstr("position[0]"));
  EXPECT_THAT(complaint<TwistStamped>("{twist: {}, twist: {}}"), HasSubstr("given twice"));
  EXPECT_THAT(complaint<TwistStamped>("{twist: \"x"), HasSubstr("the message:1: this is not YAML"));
  EXPECT_THAT(complaint<TwistStamped>("- 1"), HasSubstr("not a map"));
  EXPECT_EQ(complaint<TwistStamped>("fast"),
            "the message:1: is text, not a map of geometry_msgs/msg/TwistStamped; write {header: ..., twist: ...}, see "
            "`nacelle interface show geometry_msgs/msg/TwistStamped`");
  EXPECT_THAT(complaint<TwistStamped>("{twist: {"), HasSubstr("(column 1); write {header: ..."));
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
