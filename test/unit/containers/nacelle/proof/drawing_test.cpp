// SPDX-License-Identifier: Apache-2.0
#include "proof/drawing.hpp"

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

const std::vector<Endpoint> kPair{end("/lidar", "/scan", true), end("/monitor", "/scan", false)};

TEST(Drawing, has_a_box_for_each_node_and_an_edge_from_each_publisher_to_each_subscription) {
  std::vector<Endpoint> endpoints = kPair;
  endpoints.push_back(end("/viewer", "/scan", false));
  const std::string dot = to_dot(endpoints);
  for (const char* const part :
       {"<b>/lidar</b>", "<b>/monitor</b>", "<b>/viewer</b>", "n0:p0:e -> n1:p0:w [tooltip=\"/scan\"]",
        "n0:p0:e -> n2:p0:w [tooltip=\"/scan\"]", "sensor_msgs/msg/LaserScan<br/>keep_last 5, best_effort"})
    EXPECT_THAT(dot, HasSubstr(part));
}

TEST(Drawing, lists_what_a_node_reads_above_what_it_publishes) {
  const std::string dot = to_dot({end("/relay", "/out", true), end("/relay", "/raw", false)});
  EXPECT_LT(dot.find(">/raw<"), dot.find(">/out<"));
}

TEST(Drawing, an_end_without_another_one_is_grey) {
  EXPECT_THAT(to_dot({end("/lidar", "/scan", true)}), HasSubstr("<font color=\"#888888\">/scan"));
  EXPECT_THAT(to_dot(kPair), Not(HasSubstr("#888888")));
}

TEST(Drawing, shows_an_action_as_one_thing_from_its_server_to_its_client) {
  const std::string feedback = "example_interfaces/action/Fibonacci_FeedbackMessage";
  const std::string status = "action_msgs/msg/GoalStatusArray";
  const std::string dot = to_dot({{"/arm", "/series/_action/feedback", feedback, true, QoS(10).resolved()},
                                  {"/planner", "/series/_action/feedback", feedback, false, QoS(10).resolved()},
                                  {"/arm", "/series/_action/status", status, true, QoS(1).resolved()},
                                  {"/planner", "/series/_action/status", status, false, QoS(1).resolved()}});
  EXPECT_THAT(
      dot,
      HasSubstr(
          ">/series</font><br/><font color=\"#666666\" point-size=\"8\">example_interfaces/action/Fibonacci<br/>"));
  EXPECT_THAT(dot, HasSubstr("n0:p0:e -> n1:p0:w"));
  EXPECT_THAT(dot, Not(HasSubstr("GoalStatusArray")));
}

TEST(Drawing, is_the_same_for_the_same_endpoints) { EXPECT_EQ(to_dot(kPair), to_dot(kPair)); }

TEST(Drawing, ends_that_do_not_fit_are_red) {
  EXPECT_THAT(to_dot(kPair), Not(HasSubstr("red")));
  const std::string dot = to_dot(kPair, {"/scan /lidar", "/scan /monitor"});
  EXPECT_THAT(dot, HasSubstr("<font color=\"red\">/scan"));
  EXPECT_THAT(dot, HasSubstr("color=red];"));
}

TEST(Drawing, text_cannot_leave_its_place) {
  const std::string dot = to_dot({end("/a\"]; b [", "/<script>&", true), end("/c", "/<script>&", false)});
  EXPECT_THAT(dot, HasSubstr("<b>/a&quot;]; b [</b>"));
  EXPECT_THAT(dot, HasSubstr(">/&lt;script&gt;&amp;<"));
  EXPECT_THAT(dot, HasSubstr("tooltip=\"/<script>&\""));
}

TEST(Drawing, of_nothing_is_a_drawing) { EXPECT_THAT(to_dot({}), HasSubstr("digraph")); }

}  // namespace
}  // namespace nacelle::proof
