// SPDX-License-Identifier: Apache-2.0
#include "text/message_field.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <std_msgs/msg/string.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

namespace nacelle::text {
namespace {

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::LaserScan;
using testing::HasSubstr;

template <typename T>
std::string yaml_of_field(const T& message, const char* path, YamlOptions options = {}) {
  std::string out;
  MessageField::find(T::message_type(), path).value().append_yaml(out, &message, options);
  return out;
}

template <typename T>
std::string json_of_field(const T& message, const char* path) {
  return MessageField::find(T::message_type(), path).value().to_json(&message);
}

template <typename T>
std::string complaint_of_field(const char* path) {
  const auto found = MessageField::find(T::message_type(), path);
  return found ? "" : found.error().text();
}

TEST(MessageField, is_shown_alone_however_deep_it_lies) {
  Odometry odometry;
  odometry.pose.pose.position.y = -1.5;
  odometry.header.stamp.sec = 7;
  odometry.child_frame_id = "base_footprint";
  EXPECT_EQ(yaml_of_field(odometry, "pose.pose.position.y"), "-1.5\n");
  EXPECT_EQ(yaml_of_field(odometry, "pose.pose.position"), "x: 0.0\ny: -1.5\nz: 0.0\n");
  EXPECT_EQ(yaml_of_field(odometry, "header.stamp.sec"), "7\n");
  EXPECT_EQ(yaml_of_field(odometry, "child_frame_id"), "base_footprint\n");
  EXPECT_EQ(json_of_field(odometry, "pose.pose.position"), R"({"x":0.0,"y":-1.5,"z":0.0})");
  EXPECT_EQ(json_of_field(odometry, "header.stamp.sec"), "7");
  EXPECT_EQ(json_of_field(odometry, "child_frame_id"), R"("base_footprint")");
}

TEST(MessageField, a_list_is_one_part_long_or_short) {
  LaserScan scan;
  EXPECT_EQ(yaml_of_field(scan, "ranges"), "[]\n");
  EXPECT_EQ(json_of_field(scan, "ranges"), "[]");
  scan.ranges = {1.0F, 2.5F};
  EXPECT_EQ(yaml_of_field(scan, "ranges"), "- 1.0\n- 2.5\n");
  EXPECT_EQ(yaml_of_field(scan, "ranges", {1}), "- 1.0\n- '...'\n");
  EXPECT_EQ(json_of_field(scan, "ranges"), "[1.0,2.5]");
}

TEST(MessageField, a_text_is_written_as_it_is_so_that_a_file_can_be_made_of_it) {
  std_msgs::msg::String text;
  text.data = "<robot name=\"r\">\n  it's\n</robot>\n";
  EXPECT_EQ(yaml_of_field(text, "data", {0}), text.data);
  text.data = "5";
  EXPECT_EQ(yaml_of_field(text, "data"), "5\n") << "no quotes";
  text.data = std::string(200, 'x');
  EXPECT_EQ(yaml_of_field(text, "data", {128}), std::string(128, 'x') + "...\n");
  EXPECT_EQ(yaml_of_field(text, "data", {0}), text.data + "\n");
}

TEST(MessageField, a_name_that_is_none_is_refused_with_those_that_are) {
  EXPECT_EQ(complaint_of_field<Odometry>("pose.psoe"),
            "field pose.psoe: there is no 'psoe' in geometry_msgs/msg/PoseWithCovariance; did you mean 'pose'? its "
            "fields are pose, covariance");
  EXPECT_THAT(complaint_of_field<Odometry>("nothing_like_it"),
              HasSubstr("its fields are header, child_frame_id, pose, twist"));
  EXPECT_THAT(complaint_of_field<Odometry>("pose..pose"), HasSubstr("there is no ''"));
  EXPECT_THAT(complaint_of_field<Odometry>("pose."), HasSubstr("there is no ''"));
  EXPECT_THAT(complaint_of_field<Odometry>("child_frame_id.x"), HasSubstr("child_frame_id is a value without fields"));
  EXPECT_THAT(complaint_of_field<tf2_msgs::msg::TFMessage>("transforms.header"), HasSubstr("transforms is a list"));
}

}  // namespace
}  // namespace nacelle::text
