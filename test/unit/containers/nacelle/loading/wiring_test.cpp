// SPDX-License-Identifier: Apache-2.0
#include "loading/wiring.hpp"

#include <gtest/gtest.h>

namespace nacelle::loading {
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

std::vector<std::string> remaps_told(const std::vector<RemapRule>& rules, const std::vector<bool>& used,
                                     const std::string& node) {
  std::vector<std::string> lines;
  for (const auto& unused : unused_remaps(rules, used, node, kLidar))
    lines.push_back(std::to_string(unused.rule) + " " + unused.problem.text());
  return lines;
}

TEST(Wiring, tells_of_a_remap_that_changed_nothing) {
  const std::vector<RemapRule> rules{{RemapKind::TopicOrService, "", "scan", "/front/scan"},
                                     {RemapKind::TopicOrService, "", "diagnostisc", "/x"},
                                     {RemapKind::Topic, "", "nosuch", "/y"},
                                     {RemapKind::Service, "", "reset", "/z"},
                                     {RemapKind::Service, "", "rest", "/w"},
                                     {RemapKind::TopicOrService, "", "scan", "/other"}};
  EXPECT_EQ(remaps_told(rules, {true, false, false, true, false, false}, "/lidar"),
            (std::vector<std::string>{
                "1 -r diagnostisc:=/x: /lidar has no topic or service 'diagnostisc': remapping it to '/x' has no "
                "effect; did you mean '/diagnostics'?",
                "2 -r rostopic://nosuch:=/y: /lidar has no topic 'nosuch': remapping it to '/y' has no effect; one of "
                "/diagnostics, /front/scan, /tf",
                "4 -r rosservice://rest:=/w: /lidar has no service 'rest': remapping it to '/w' has no effect; the "
                "only choice is /z",
                "5 -r scan:=/other: /lidar remaps 'scan' twice: the first rule wins, to '/front/scan'; leave one of "
                "them out"}));
}

TEST(Wiring, a_remap_to_a_topic_that_is_there_anyway_is_no_hit) {
  EXPECT_EQ(remaps_told({{RemapKind::TopicOrService, "", "diagnostisc", "/diagnostics"}}, {false}, "/lidar"),
            (std::vector<std::string>{
                "0 -r diagnostisc:=/diagnostics: /lidar has no topic or service 'diagnostisc': remapping it to "
                "'/diagnostics' has no effect; one of /front/scan, /tf, /z"}));
  EXPECT_EQ(remaps_told({{RemapKind::TopicOrService, "", "tf", "/tf"}}, {false}, "/lidar"),
            (std::vector<std::string>{"0 -r tf:=/tf: 'tf' is remapped to itself; leave the rule out"}));
}

TEST(Wiring, a_remap_for_another_node_is_reported) {
  EXPECT_EQ(remaps_told({{RemapKind::TopicOrService, "lidr", "scan", "/x"}}, {false}, "/lidar"),
            (std::vector<std::string>{"0 -r lidr:scan:=/x: the rule is for a node 'lidr', and this one is 'lidar'; did "
                                      "you mean 'lidar'?"}));
}

TEST(Wiring, an_action_is_a_name_that_a_rule_may_have_meant) {
  const TopicEnds arm{{"/arm/_action/feedback", "/arm/_action/status"}, {}, {"/arm/_action/send_goal"}};
  const auto unused = unused_remaps({{RemapKind::Service, "", "arn", "/x"}}, {false}, "/node", arm);
  ASSERT_EQ(unused.size(), 1U);
  EXPECT_EQ(unused[0].problem.way_out, "did you mean '/arm'?");
}

}  // namespace
}  // namespace nacelle::loading
