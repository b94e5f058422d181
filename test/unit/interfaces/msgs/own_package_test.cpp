// SPDX-License-Identifier: Apache-2.0
#include "msgs_test_support.hpp"

#include <my_robot_msgs/action/trace.hpp>
#include <my_robot_msgs/msg/odds.hpp>
#include <my_robot_msgs/msg/shape.hpp>
#include <my_robot_msgs/srv/paint.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <type_traits>

namespace nacelle {
namespace {

using my_robot_msgs::msg::Odds;
using my_robot_msgs::msg::Shape;

TEST(OwnPackage, has_its_constants) {
  static_assert(Odds::CLASS == 1 && Odds::ON);
  static_assert(Odds::LOWEST == std::numeric_limits<std::int64_t>::min());
  static_assert(Odds::HIGHEST == std::numeric_limits<std::uint64_t>::max());
  static_assert(Odds::HALF == 0.5F && Odds::ENDLESS == std::numeric_limits<double>::infinity());
  EXPECT_STREQ(Odds::GREETING, "hello, world");
}

TEST(OwnPackage, has_its_defaults_under_names_that_cpp_allows) {
  const Odds odds;
  EXPECT_EQ(odds.class_, true);
  EXPECT_EQ(odds.new_, -5);
  EXPECT_EQ(odds.default_, 200);
  EXPECT_EQ(odds.operator_, -300);
  EXPECT_EQ(odds.namespace_, 60000);
  EXPECT_EQ(odds.delete_, -70000);
  EXPECT_EQ(odds.template_, 4000000000U);
  EXPECT_EQ(odds.int_, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(odds.message_type_, std::numeric_limits<std::uint64_t>::max());
  EXPECT_TRUE(std::isnan(odds.not_a_number));
  EXPECT_EQ(odds.minus_infinity, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(odds.tenth, 0.1);
  EXPECT_EQ(odds.octet, 255);
  EXPECT_EQ(odds.letter, 65);
  EXPECT_EQ(odds.name, "a \"quoted\" name that is too long for the small string");
  EXPECT_EQ(odds.short_name, "eight ch");
  EXPECT_EQ(odds.wide, u"sch\u00f6n");
  EXPECT_EQ(odds.triple, (std::array<std::int32_t, 3>{1, -2, 3}));
  EXPECT_EQ(odds.few, (Buffer<double>{0.5, 1.5}));
  EXPECT_EQ(odds.bytes, (Buffer<std::uint8_t>{1, 2, 255}));
  EXPECT_EQ(odds.flags, (Buffer<bool>{true, false, true}));
  EXPECT_EQ(odds.words, (std::vector<std::string>{"one", "two, three"}));
  EXPECT_EQ(odds.two_words, (std::array<std::string, 2>{"left", "right"}));
}

TEST(OwnPackage, uses_messages_of_other_packages) {
  static_assert(std::is_same_v<decltype(Shape::header), std_msgs::msg::Header>);
  static_assert(std::is_same_v<decltype(Shape::outline), std::vector<geometry_msgs::msg::Point>>);
  static_assert(std::is_same_v<decltype(Shape::images), std::vector<sensor_msgs::msg::Image>>);
  static_assert(std::is_same_v<decltype(Shape::corners), std::array<my_robot_msgs::msg::Corner, 4>>);
  EXPECT_STREQ(Shape::message_type().name, "my_robot_msgs/msg/Shape");
}

TEST(OwnPackage, has_services_and_actions) {
  using my_robot_msgs::action::Trace;
  using my_robot_msgs::srv::Paint;
  EXPECT_EQ(Paint::Request{}.colour, 1);
  EXPECT_EQ(Paint::Request::RED, 0);
  EXPECT_EQ(&Paint::service_type().response(), &Paint::Response::message_type());
  EXPECT_EQ(Trace::Goal{}.speed, 0.25);
  EXPECT_EQ(Trace::SendGoal::Request{}.goal.speed, 0.25);
  EXPECT_STREQ(Trace::action_type().name, "my_robot_msgs/action/Trace");
}

TEST(OwnPackage, is_found_at_run_time) {
  const auto found = test::type_library().message("my_robot_msgs/srv/Paint_Event");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_STREQ((*found)->hash, my_robot_msgs::srv::Paint::Event::message_type().hash);
}

}  // namespace
}  // namespace nacelle
