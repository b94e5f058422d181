// SPDX-License-Identifier: Apache-2.0
#include "record/model/field_path.hpp"

#include <gtest/gtest.h>

#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <tf2_msgs/msg/tf_message.hpp>

namespace nacelle::record {
namespace {

using nav_msgs::msg::Odometry;
using sensor_msgs::msg::LaserScan;

TEST(FieldPath, has_names_and_indexes) {
  using Kind = PathStep::Kind;
  const std::vector<PathStep> expected{
      {Kind::Field, "points", 0}, {Kind::EveryElement, "", 0}, {Kind::Field, "xs", 0}, {Kind::Element, "", 12}};
  const auto parsed = parse_field_path("points[*].xs[12]");
  ASSERT_TRUE(parsed) << parsed.error().text();
  EXPECT_EQ(*parsed, expected);
}

TEST(FieldPath, refuses_what_is_none) {
  for (const char* text : {"", ".", "a.", ".a", "a..b", "a[", "a[]", "a[x]", "a[-1]", "a[1 ]", "[1]", "a]", "a[1]b",
                           "a[99999999999999999999]"}) {
    const auto parsed = parse_field_path(text);
    EXPECT_FALSE(parsed) << text;
  }
}

std::string problem_of(const msgs::MessageType& type, const char* path) {
  const auto found = NumericField::find(type, path);
  return found ? "none" : found.error().text();
}

TEST(NumericField, reads_nested_values_arrays_and_lists) {
  Odometry odometry;
  odometry.header.stamp.sec = 3;
  odometry.header.stamp.nanosec = 500'000'000;
  odometry.pose.pose.position.y = -2.5;
  odometry.pose.covariance[35] = 0.25;
  const auto read = [&](const char* path) {
    const auto field = NumericField::find(Odometry::message_type(), path);
    return field ? field->read(&odometry) : std::nullopt;
  };
  EXPECT_EQ(read("pose.pose.position.y"), -2.5);
  EXPECT_EQ(read("pose.covariance[35]"), 0.25);
  EXPECT_EQ(read("header.stamp"), 3.5) << "in seconds";

  LaserScan scan;
  scan.ranges = {1.0F, 2.0F};
  const auto third = NumericField::find(LaserScan::message_type(), "ranges[2]");
  ASSERT_TRUE(third);
  EXPECT_EQ(third->read(&scan), std::nullopt) << "it has two";
  scan.ranges.push_back(4.0F);
  EXPECT_EQ(third->read(&scan), 4.0);

  tf2_msgs::msg::TFMessage tree;
  tree.transforms.resize(2);
  tree.transforms[1].transform.translation.x = 7.0;
  const auto x = NumericField::find(tf2_msgs::msg::TFMessage::message_type(), "transforms[1].transform.translation.x");
  ASSERT_TRUE(x);
  EXPECT_EQ(x->read(&tree), 7.0);
}

TEST(NumericField, names_the_nearest_field) {
  const auto& type = Odometry::message_type();
  EXPECT_NE(problem_of(type, "pose.pose.positon.x").find("did you mean 'position'?"), std::string::npos);
  EXPECT_NE(problem_of(type, "speed").find("its fields are header, child_frame_id, pose, twist"), std::string::npos);
}

TEST(NumericField, refuses_what_is_no_number) {
  const auto& type = Odometry::message_type();
  EXPECT_NE(problem_of(type, "child_frame_id").find("it is a text"), std::string::npos);
  EXPECT_NE(problem_of(type, "pose.pose.position").find("its fields are x, y, z"), std::string::npos);
  EXPECT_NE(problem_of(type, "pose.covariance").find("give an index: pose.covariance[0]"), std::string::npos);
  EXPECT_NE(problem_of(type, "pose.covariance[36]").find("has 36 elements"), std::string::npos);
  EXPECT_NE(problem_of(type, "pose.covariance[*]").find("'*' stands for many"), std::string::npos);
  EXPECT_NE(problem_of(type, "pose[0]").find("pose is no list"), std::string::npos);
  EXPECT_NE(problem_of(type, "pose.pose.position.x.y").find("a value without fields"), std::string::npos);
  EXPECT_NE(problem_of(type, "header.stamp.sec").find("a value without fields"), std::string::npos);
}

TEST(FieldPath, with_a_wildcard_is_checked_too) {
  EXPECT_TRUE(check_field_path(Odometry::message_type(), "pose.covariance[*]"));
  EXPECT_TRUE(check_field_path(Odometry::message_type(), "pose.covariance"));
  EXPECT_FALSE(check_field_path(Odometry::message_type(), "pose.variance[*]"));
}

}  // namespace
}  // namespace nacelle::record
