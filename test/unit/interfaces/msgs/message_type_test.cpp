// SPDX-License-Identifier: Apache-2.0
#include "msgs_test_support.hpp"

#include <my_robot_msgs/msg/odds.hpp>
#include <my_robot_msgs/msg/shape.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nav2_msgs/action/navigate_to_pose.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <sensor_msgs/msg/imu.hpp>

namespace nacelle {
namespace {

using my_robot_msgs::msg::Odds;
using my_robot_msgs::msg::Shape;

/// Foreign memory that counts how often it came back.
struct Lender {
  std::uint8_t memory[16] = {1, 2, 3};
  int returned = 0;
  void lend_to(Buffer<std::uint8_t>& buffer) {
    buffer.adopt(memory, 3, sizeof memory,
                 {[](void* context) noexcept { ++static_cast<Lender*>(context)->returned; }, this});
  }
};

TEST(MessageType, names_itself_as_ros2_does) {
  const auto& type = sensor_msgs::msg::Image::message_type();
  EXPECT_STREQ(type.name, "sensor_msgs/msg/Image");
  EXPECT_STREQ(type.dds_name, "sensor_msgs::msg::dds_::Image_");
  EXPECT_EQ(type.size, sizeof(sensor_msgs::msg::Image));
  EXPECT_EQ(type.alignment, alignof(sensor_msgs::msg::Image));
}

TEST(MessageType, of_an_actions_parts_is_reached_from_the_action) {
  using nav2_msgs::action::NavigateToPose;
  const auto& action = NavigateToPose::action_type();
  EXPECT_STREQ(action.name, "nav2_msgs/action/NavigateToPose");
  EXPECT_EQ(&action.goal(), &NavigateToPose::Goal::message_type());
  EXPECT_EQ(&action.feedback_message(), &NavigateToPose::FeedbackMessage::message_type());
  EXPECT_EQ(&action.send_goal(), &NavigateToPose::SendGoal::service_type());
  EXPECT_STREQ(NavigateToPose::GetResult::service_type().response().dds_name,
               "nav2_msgs::action::dds_::NavigateToPose_GetResult_Response_");
  EXPECT_STREQ(NavigateToPose::SendGoal::Event::message_type().name, "nav2_msgs/action/NavigateToPose_SendGoal_Event");
}

TEST(MessageType, gives_a_new_message_its_defaults) {
  msgs::AnyMessage message{Odds::message_type()};
  EXPECT_EQ(static_cast<const Odds*>(message.get())->name, Odds{}.name);
}

TEST(MessageType, copies_and_moves_like_the_struct) {
  const auto& type = Odds::message_type();
  Odds from;
  from.name = "a text that does not fit into the string itself";
  from.not_a_number = 0.0F;
  const Odds original = from;
  Odds copy;
  Odds moved;

  type.copy_assign(&copy, &from);
  EXPECT_EQ(from, original);
  type.move_assign(&moved, &from);

  EXPECT_EQ(copy, original);
  EXPECT_EQ(moved, original);
}

TEST(Recycle, returns_foreign_buffers_from_everywhere_in_the_message_once) {
  Lender lenders[3];
  Shape shape;
  shape.images.resize(2);
  Odds odds;
  lenders[0].lend_to(shape.images[0].data);
  lenders[1].lend_to(shape.images[1].data);
  lenders[2].lend_to(odds.bytes);

  Shape::message_type().recycle(&shape);
  Odds::message_type().recycle(&odds);
  Odds::message_type().recycle(&odds);

  for (const auto& lender : lenders) EXPECT_EQ(lender.returned, 1);
  EXPECT_TRUE(shape.images[1].data.empty());
}

TEST(Recycle, keeps_values_and_capacity) {
  sensor_msgs::msg::Image image;
  image.header.frame_id = "a frame with a long name, longer than a small string";
  image.width = 640;
  image.data.resize(1000);
  const auto* const data = image.data.data();

  sensor_msgs::msg::Image::message_type().recycle(&image);

  EXPECT_EQ(image.width, 640U);
  EXPECT_EQ(image.data.data(), data);
  EXPECT_EQ(image.data.size(), 1000U);
  EXPECT_EQ(image.header.frame_id, "a frame with a long name, longer than a small string");
}

TEST(Poison, spoils_every_number_of_the_fixed_parts_and_nothing_else) {
  sensor_msgs::msg::Imu imu;
  imu.header.frame_id = "imu_link";
  sensor_msgs::msg::Imu::message_type().poison(&imu);
  EXPECT_TRUE(std::isnan(imu.orientation.w));
  EXPECT_TRUE(std::isnan(imu.linear_acceleration_covariance[8]));
  EXPECT_EQ(imu.header.stamp.nanosec, 0xCDCDCDCDU);
  EXPECT_EQ(imu.header.frame_id, "imu_link");

  Shape shape;
  shape.outline.resize(1);
  Shape::message_type().poison(&shape);
  EXPECT_TRUE(std::isnan(shape.corners[3].position.y));
  EXPECT_EQ(shape.corners[3].count, 0xCDCD);
  EXPECT_EQ(shape.outline[0].x, 0.0);
}

TEST(Reflection, reaches_every_field_by_name) {
  const auto& type = Odds::message_type();
  const auto& first = type.fields.front();
  EXPECT_STREQ(first.name, "class");
  EXPECT_EQ(first.kind, msgs::Kind::Bool);
  EXPECT_EQ(first.offset, 0U);
  EXPECT_STREQ(first.default_json, "true");

  const auto few =
      std::find_if(type.fields.begin(), type.fields.end(), [](const auto& f) { return std::string("few") == f.name; });
  ASSERT_NE(few, type.fields.end());
  EXPECT_EQ(few->shape, msgs::Shape::BoundedSequence);
  EXPECT_EQ(few->bound, 4U);
  Odds odds;
  const auto* const sequence = reinterpret_cast<const std::uint8_t*>(&odds) + few->offset;
  EXPECT_EQ(few->sequence->size(sequence), 2U);
  EXPECT_EQ(few->sequence->data(sequence), odds.few.data());
}

TEST(Definition, has_the_text_and_then_each_dependency_once) {
  const std::string text = Shape::message_type().definition;
  EXPECT_TRUE(text.starts_with("Header header\n")) << text;
  for (const char* dependency : {"std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Point",
                                 "my_robot_msgs/Corner", "my_robot_msgs/Nothing", "sensor_msgs/Image"}) {
    const std::string line = std::string(80, '=') + "\nMSG: " + dependency + "\n";
    const auto at = text.find(line);
    ASSERT_NE(at, std::string::npos) << dependency;
    EXPECT_EQ(text.find(line, at + 1), std::string::npos) << dependency;
  }
}

TEST(Definition, keeps_comments_as_they_were_written) {
  EXPECT_THAT(Odds::message_type().definition,
              testing::HasSubstr(
                  "# Everything that a generator may stumble over: C:\\users\\xavier \\u1 \"quotes\" 50 \u00b0C ?\?/"));
}

}  // namespace
}  // namespace nacelle
