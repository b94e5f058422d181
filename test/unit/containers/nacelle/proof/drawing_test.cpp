// SPDX-License-Identifier: Apache-2.0
#include "nacelle/proof/drawing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nacelle::proof {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string kScan = "sensor_msgs/msg/LaserScan";

Endpoint end(const std::string& node, const std::string& topic, bool publishes) {
  return {node, topic, kScan, publishes, QoS(5).best_effort().resolved()};
}

const Drawing::Vertex& vertex(const Drawing& drawing, const std::string& name) {
  for (const auto& v : drawing.vertices) {
    if (v.name == name) return v;
  }
  throw std::out_of_range(name);
}

TEST(Drawing, goes_from_the_publisher_over_the_topic_to_the_subscription) {
  const Drawing drawing = draw({end("/lidar", "/scan", true), end("/monitor", "/scan", false)});
  EXPECT_EQ(vertex(drawing, "/lidar").column, 0);
  EXPECT_EQ(vertex(drawing, "/scan").column, 1);
  EXPECT_EQ(vertex(drawing, "/monitor").column, 2);
  EXPECT_EQ(vertex(drawing, "/scan").detail, kScan);
  ASSERT_EQ(drawing.edges.size(), 2U);
  EXPECT_THAT(drawing.edges[0].label, HasSubstr("best_effort"));
}

TEST(Drawing, cuts_a_circle_and_keeps_every_edge) {
  const Drawing drawing = draw({end("/a", "/there", true), end("/b", "/there", false), end("/b", "/back", true),
                                end("/a", "/back", false), end("/a", "/there", false)});
  EXPECT_EQ(drawing.edges.size(), 5U);
  for (const auto& v : drawing.vertices) EXPECT_LT(v.column, 4) << v.name;
}

TEST(Drawing, a_chain_of_a_thousand_steps_has_a_column_for_each) {
  std::vector<Endpoint> endpoints;
  for (int i = 0; i < 500; ++i) {
    endpoints.push_back(end("/n" + std::to_string(i), "/t" + std::to_string(i), true));
    endpoints.push_back(end("/n" + std::to_string(i + 1), "/t" + std::to_string(i), false));
  }
  EXPECT_EQ(vertex(draw(endpoints), "/n500").column, 1000);
}

TEST(Drawing, shows_an_action_as_one_thing_from_its_server_to_its_client) {
  const std::string feedback = "example_interfaces/action/Fibonacci_FeedbackMessage";
  const std::string status = "action_msgs/msg/GoalStatusArray";
  const Drawing drawing = draw({{"/arm", "/series/_action/feedback", feedback, true, QoS(10).resolved()},
                                {"/planner", "/series/_action/feedback", feedback, false, QoS(10).resolved()},
                                {"/arm", "/series/_action/status", status, true, QoS(1).resolved()},
                                {"/planner", "/series/_action/status", status, false, QoS(1).resolved()}});
  EXPECT_EQ(drawing.vertices.size(), 3U);
  EXPECT_EQ(vertex(drawing, "/series").detail, "example_interfaces/action/Fibonacci");
  EXPECT_EQ(vertex(drawing, "/arm").column, 0);
  EXPECT_EQ(vertex(drawing, "/planner").column, 2);
}

TEST(Drawing, is_the_same_for_the_same_endpoints) {
  const std::vector<Endpoint> endpoints{end("/lidar", "/scan", true), end("/monitor", "/scan", false)};
  EXPECT_EQ(to_svg(draw(endpoints)), to_svg(draw(endpoints)));
  EXPECT_EQ(to_dot(draw(endpoints)), to_dot(draw(endpoints)));
}

TEST(Drawing, ends_that_do_not_fit_are_red) {
  const std::vector<Endpoint> endpoints{end("/lidar", "/scan", true), end("/monitor", "/scan", false)};
  EXPECT_THAT(to_dot(draw(endpoints)), Not(HasSubstr("red")));
  EXPECT_THAT(to_dot(draw(endpoints, {"/scan /monitor"})), HasSubstr("color=red"));
  EXPECT_THAT(to_svg(draw(endpoints, {"/scan /monitor"})), HasSubstr("crimson"));
}

TEST(Drawing, text_cannot_leave_its_place) {
  const std::vector<Endpoint> endpoints{end("/a\"]; b [", "/<script>&", true)};
  EXPECT_THAT(to_dot(draw(endpoints)), HasSubstr("label=\"/a\\\"]; b [\""));
  EXPECT_THAT(to_svg(draw(endpoints)), HasSubstr("/&lt;script&gt;&amp;"));
  EXPECT_THAT(to_svg(draw(endpoints)), Not(HasSubstr("<script>")));
}

TEST(Drawing, of_nothing_is_a_drawing) {
  EXPECT_THAT(to_svg(draw({})), HasSubstr("</svg>"));
  EXPECT_THAT(to_dot(draw({})), HasSubstr("digraph"));
}

}  // namespace
}  // namespace nacelle::proof
