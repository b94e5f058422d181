// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/wiring.hpp"

#include <gtest/gtest.h>

namespace nacelle::session {
namespace {

const TopicEnds kLidar{{"/front/scan", "/diagnostics"}, {"/tf"}, {"/z"}};

std::vector<std::string> texts(const std::vector<Problem>& problems) {
  std::vector<std::string> lines;
  for (const auto& problem : problems) lines.push_back(problem.text());
  return lines;
}

launch::TopicQos qos(const std::string& topic, launch::Side side) {
  return {topic, side, {}, {}, {"robot.launch.yaml", 12}};
}

TEST(Wiring, tells_of_a_quality_of_service_for_a_topic_that_the_component_does_not_have) {
  launch::ComponentPlan plan;
  plan.name = "lidar";
  plan.qos = {qos("/front/scan", launch::Side::Publisher), qos("/front/scna", launch::Side::Publisher),
              qos("/front/scan", launch::Side::Subscription), qos("/tf", launch::Side::Publisher)};
  EXPECT_EQ(
      texts(unused_qos(plan, kLidar)),
      (std::vector<std::string>{
          "robot.launch.yaml:12: /lidar has no topic '/front/scna': this quality of service has no effect; did you "
          "mean '/front/scan'?",
          "robot.launch.yaml:12: /lidar does not subscribe to '/front/scan': this quality of service has no effect; "
          "write 'publisher'",
          "robot.launch.yaml:12: /lidar does not publish '/tf': this quality of service has no effect; write "
          "'subscription'"}));
}

TEST(Wiring, tells_of_a_remap_that_changed_nothing) {
  const std::vector<RemapRule> rules{{RemapKind::TopicOrService, "", "scan", "/front/scan"},
                                     {RemapKind::TopicOrService, "", "diagnostisc", "/x"},
                                     {RemapKind::Topic, "", "nosuch", "/y"},
                                     {RemapKind::Service, "", "reset", "/z"},
                                     {RemapKind::Service, "", "rest", "/w"}};
  EXPECT_EQ(texts(unused_remaps(rules, "/lidar", kLidar)),
            (std::vector<std::string>{
                "-r diagnostisc:=/x: /lidar has no topic or service 'diagnostisc': remapping it to '/x' has no effect; "
                "did you mean '/diagnostics'?",
                "-r rostopic://nosuch:=/y: /lidar has no topic 'nosuch': remapping it to '/y' has no effect; one of "
                "/diagnostics, /front/scan, /tf",
                "-r rosservice://rest:=/w: /lidar has no service 'rest': remapping it to '/w' has no effect; the only "
                "choice is /z"}));
}

TEST(Wiring, reads_relative_names_in_the_namespace_of_the_node) {
  EXPECT_TRUE(unused_remaps({{RemapKind::TopicOrService, "", "laser", "scan"}}, "/front/lidar", kLidar).empty());
  EXPECT_FALSE(unused_remaps({{RemapKind::TopicOrService, "", "laser", "scan"}}, "/lidar", kLidar).empty());
}

TEST(Wiring, takes_a_remap_of_an_action_for_what_it_is) {
  const TopicEnds arm{{"/arm/_action/feedback", "/arm/_action/status"}, {}, {"/arm/_action/send_goal"}};
  EXPECT_TRUE(unused_remaps({{RemapKind::TopicOrService, "", "series", "/arm"}}, "/node", arm).empty());
  EXPECT_TRUE(unused_remaps({{RemapKind::Service, "", "series", "/arm"}}, "/node", arm).empty());
  EXPECT_FALSE(unused_remaps({{RemapKind::Topic, "", "series", "/arm"}}, "/node", arm).empty());
  EXPECT_FALSE(unused_remaps({{RemapKind::TopicOrService, "", "series", "/leg"}}, "/node", arm).empty());
}

}  // namespace
}  // namespace nacelle::session
