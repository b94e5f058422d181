// SPDX-License-Identifier: Apache-2.0
#include "nacelle/host/remap_notes.hpp"

#include <gtest/gtest.h>

#include <std_msgs/msg/string.hpp>

#include "nacelle/node/node.hpp"
#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;

TEST(RemapNotes, a_rule_is_used_when_it_changed_a_name) {
  test::RecordingContext context;
  const std::vector<RemapRule> rules{{RemapKind::TopicOrService, "", "scan", "/front/scan"},
                                     {RemapKind::TopicOrService, "", "odmo", "/odom"},
                                     {RemapKind::TopicOrService, "", "odom", "/odom"},
                                     {RemapKind::TopicOrService, "", "scan", "/rear/scan"},
                                     {RemapKind::Topic, "other", "map", "/x"}};
  const RemapNotes notes{rules.size()};
  Node node{"node", NodeOptions{context}.remap_rules(rules)};
  const auto scan = node.create_publisher<String>("scan", QoS(1));
  const auto odom = node.create_publisher<String>("odom", QoS(1));
  const auto map = node.create_publisher<String>("map", QoS(1));
  EXPECT_EQ(notes.used(), (std::vector<bool>{true, false, false, false, false}));
}

TEST(RemapNotes, the_innermost_notes_and_the_outer_goes_on_after_it) {
  test::RecordingContext context;
  const std::vector<RemapRule> rules{{RemapKind::TopicOrService, "", "a", "b"}};
  const RemapNotes outer{1};
  {
    const RemapNotes inner{1};
    Node node{"node", NodeOptions{context}.remap_rules(rules)};
    static_cast<void>(node.resolve_topic_name("a"));
    EXPECT_EQ(inner.used(), std::vector<bool>{true});
  }
  EXPECT_EQ(outer.used(), std::vector<bool>{false});
  Node node{"second", NodeOptions{context}.remap_rules(rules)};
  static_cast<void>(node.resolve_topic_name("a"));
  EXPECT_EQ(outer.used(), std::vector<bool>{true});
}

}  // namespace
}  // namespace nacelle
