// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "in_memory.hpp"

namespace nacelle::launch {
namespace {

using NamedArguments = std::map<std::string, std::string>;

constexpr const char* kRobot = R"(
- network: {export: [scan, /tf]}
- set_env: {name: A, value: b}
- node: {pkg: demo, exec: talker, name: talker, param: [{from: robot.yaml}]}
- node_container:
    name: robot
    param: [{name: hang_after, value: 2.0}]
    composable_node:
    - {pkg: p, plugin: p::Base, name: base, param: [{from: robot.yaml}]}
    - pkg: p
      plugin: p::Lidar
      name: lidar
      namespace: front
      remap: [{from: scan, to: /scan}, {from: points, to: points_raw}]
      after: [{node: /base, when: tf(odom->base_link)}, {node: base, when: first_message(odom)}]
      qos: {/scan: {publisher: {depth: 2}}, ~/state: {publisher: {depth: 3}}}
)";
const std::map<std::string, std::string> kFiles{
    {"robot.yaml",
     "base: {ros__parameters: {speed: 1.0, width: 0.3}}\n/robot1/base: {ros__parameters: {speed: 2.0}}\n"
     "talker: {ros__parameters: {rate: 3}}\n"}};

Result<Plan, std::vector<Problem>> load_named(const std::string& text, const NamedArguments& arguments = {}) {
  return load_plan_text("launch:\n" + text, "a.launch.yaml", arguments, in_memory(kFiles));
}
Plan plan_named(const std::string& text, const NamedArguments& arguments = {}) {
  auto plan = load_named(text, arguments);
  EXPECT_TRUE(plan) << problems_of(plan);
  return plan ? std::move(*plan) : Plan{};
}
std::string refused_names(const std::string& text, const NamedArguments& arguments = {}) {
  return problems_of(load_named(text, arguments));
}
std::vector<std::string> rules_of(const ComponentPlan& component) {
  std::vector<std::string> all;
  for (const auto& rule : component.remaps) all.push_back(nacelle::to_text(rule));
  return all;
}
std::string value_of(const std::vector<Parameter>& parameters, const std::string& name) {
  const auto found = std::find_if(parameters.begin(), parameters.end(), [&](const auto& p) { return p.name == name; });
  return found == parameters.end() ? "none" : to_text(found->value);
}
std::string words_of_program(const Plan& plan) {
  std::string all;
  for (const auto& word : plan.programs.at(0).command_arguments()) all += word + " ";
  return all;
}

TEST(Namespace, of_the_command_line_puts_every_node_below_it) {
  const Plan plan = plan_named(kRobot, {{"namespace", "robot1"}});
  EXPECT_EQ(plan.name_space.path, "/robot1");
  EXPECT_EQ(plan.container.namespace_, "/robot1");
  ASSERT_EQ(plan.components.size(), 2U);
  EXPECT_EQ(plan.components[0].full_name(), "/robot1/base");
  EXPECT_EQ(plan.components[1].full_name(), "/robot1/front/lidar");
  EXPECT_EQ(plan.programs.at(0).namespace_, "/robot1");
  EXPECT_NE(words_of_program(plan).find("-r __ns:=/robot1 "), std::string::npos) << words_of_program(plan);
}

TEST(Namespace, moves_transforms_to_topics_of_their_own_unless_frames_are_asked_for) {
  const Plan topics = plan_named(kRobot, {{"namespace", "robot1"}});
  EXPECT_EQ(topics.name_space.tf_topic(), "/robot1/tf");
  EXPECT_EQ(topics.name_space.frame("odom"), "odom");
  EXPECT_EQ(rules_of(topics.components[0]),
            (std::vector<std::string>{"rostopic:///tf:=/robot1/tf", "rostopic:///tf_static:=/robot1/tf_static"}));
  EXPECT_EQ(topics.components[0].shared_remaps, 2U);
  EXPECT_EQ(value_of(topics.components[0].parameters, "frame_prefix"), "none");
  EXPECT_EQ(topics.components[1].after[0].detail, "odom->base_link");
  EXPECT_NE(words_of_program(topics).find("/tf:=/robot1/tf"), std::string::npos);

  const Plan frames = plan_named(kRobot, {{"namespace", "fleet/robot1"}, {"tf", "frames"}});
  EXPECT_EQ(frames.name_space.tf_topic(), "/tf");
  EXPECT_EQ(frames.name_space.frame("odom"), "fleet/robot1/odom");
  EXPECT_EQ(frames.name_space.frame("fleet/robot1/odom"), "fleet/robot1/odom");
  EXPECT_EQ(frames.name_space.frame("/map"), "map");
  EXPECT_TRUE(rules_of(frames.components[0]).empty());
  EXPECT_EQ(value_of(frames.components[0].parameters, "frame_prefix"), "fleet/robot1/");
  EXPECT_EQ(frames.components[1].after[0].detail, "fleet/robot1/odom->fleet/robot1/base_link");
  EXPECT_NE(words_of_program(frames).find("-p frame_prefix:=fleet/robot1/"), std::string::npos);
  // The container has no frames.
  EXPECT_EQ(value_of(frames.container.parameters, "frame_prefix"), "none");
  EXPECT_EQ(value_of(frames.container.parameters, "hang_after"), "2.0");
}

TEST(Namespace, leaves_absolute_topics_where_they_are) {
  const Plan plan = plan_named(kRobot, {{"namespace", "robot1"}});
  EXPECT_EQ(rules_of(plan.components[1]).at(2), "scan:=/scan");
  EXPECT_EQ(plan.components[1].qos.at(0).topic, "/scan");
  EXPECT_EQ(plan.components[1].qos.at(1).topic, "/robot1/front/lidar/state");
  EXPECT_EQ(plan.network.exports.at(0).topic, "/robot1/scan");
  EXPECT_EQ(plan.network.exports.at(1).topic, "/tf");
}

TEST(Namespace, finds_nodes_and_parameters_by_the_names_that_the_files_give_them) {
  const Plan plan = plan_named(kRobot, {{"namespace", "robot1"}});
  EXPECT_EQ(plan.components[1].after.at(0).node, "/robot1/base");
  EXPECT_EQ(plan.components[1].after.at(1).node, "/robot1/base");
  EXPECT_EQ(plan.components[1].after.at(1).detail, "/robot1/odom");
  // What is written for this robot stands later in the file, and wins.
  EXPECT_EQ(value_of(plan.components[0].parameters, "speed"), "2.0");
  EXPECT_EQ(value_of(plan.components[0].parameters, "width"), "0.3");
  // A program of ROS 2 would look for /robot1/talker in the file.
  EXPECT_NE(words_of_program(plan).find("-p rate:=3"), std::string::npos) << words_of_program(plan);
  EXPECT_TRUE(plan.unused_sections.empty());

  const Plan other = plan_named(kRobot, {{"namespace", "robot2"}});
  EXPECT_EQ(value_of(other.components[0].parameters, "speed"), "1.0");
  ASSERT_EQ(other.unused_sections.size(), 1U);
  EXPECT_EQ(other.unused_sections[0].pattern, "/robot1/base");
}

TEST(Namespace, stands_in_the_file_too_and_the_command_line_wins) {
  const std::string file = std::string("- namespace: {name: robot1, tf: frames}\n") + kRobot;
  const Plan plan = plan_named(file);
  EXPECT_TRUE(plan.name_space.declared);
  EXPECT_EQ(plan.components[0].full_name(), "/robot1/base");
  EXPECT_EQ(value_of(plan.components[0].parameters, "frame_prefix"), "robot1/");
  EXPECT_EQ(plan.network.exports.at(0).topic, "/robot1/scan");

  const Plan given = plan_named(file, {{"namespace", "robot2"}});
  EXPECT_EQ(given.components[0].full_name(), "/robot2/base");
  EXPECT_EQ(value_of(given.components[0].parameters, "frame_prefix"), "robot2/");
  const Plan both = plan_named(file, {{"namespace", "robot2"}, {"tf", "topics"}});
  EXPECT_EQ(both.name_space.tf_topic(), "/robot2/tf");
  EXPECT_EQ(value_of(both.components[0].parameters, "frame_prefix"), "none");
  const Plan none = plan_named(file, {{"namespace", ""}});
  EXPECT_EQ(none.components[0].full_name(), "/base");
  EXPECT_EQ(value_of(none.components[0].parameters, "frame_prefix"), "none");
  EXPECT_EQ(to_text(none), to_text(plan_named(kRobot)));
}

TEST(Namespace, holds_in_groups_that_forward_nothing) {
  const Plan group = plan_named(R"(
- node_container: {name: robot}
- group:
  - push_ros_namespace: {namespace: arm}
  - load_composable_node: {target: robot, composable_node: [{pkg: p, plugin: p::C, name: c}]}
)",
                                {{"namespace", "robot1"}, {"tf", "frames"}});
  EXPECT_EQ(group.components.at(0).full_name(), "/robot1/arm/c");
  EXPECT_EQ(value_of(group.components.at(0).parameters, "frame_prefix"), "robot1/");
}

TEST(Namespace, is_the_files_own_argument_if_it_declares_one) {
  const Plan plan = plan_named(R"(
- arg: {name: namespace, default: ''}
- push_ros_namespace: {namespace: $(var namespace)}
- node_container: {name: robot, composable_node: [{pkg: p, plugin: p::Base, name: base}]}
)",
                               {{"namespace", "robot1"}});
  EXPECT_FALSE(plan.name_space.moves());
  EXPECT_EQ(plan.components.at(0).full_name(), "/robot1/base");
  EXPECT_TRUE(rules_of(plan.components.at(0)).empty());
}

TEST(Namespace, is_refused_where_it_cannot_be_meant) {
  const struct {
    std::string text;
    NamedArguments arguments;
    std::string expected;
  } cases[] = {
      {"- log: {message: a}",
       {{"namespace", "1st"}},
       "namespace:=1st: the namespace '/1st' has a part that starts with a digit\n"},
      {"- log: {message: a}",
       {{"namespace", "r"}, {"tf", "frame"}},
       "tf:=frame: 'frame' is no way to keep transforms apart; did you mean 'frames'?\n"},
      {"- log: {message: a}",
       {{"tf", "frames"}},
       "tf:=frames: nothing is moved, so transforms stay; give a namespace, too: namespace:=robot1\n"},
      {"- namespace: {name: a}\n- namespace: {name: b}",
       {},
       "a.launch.yaml:3: a second 'namespace'; the first is at a.launch.yaml:2; push_ros_namespace moves a part of the "
       "nodes\n"},
      {"- node_container: {name: robot}\n- namespace: {name: a}",
       {},
       "a.launch.yaml:3: 'namespace' moves all nodes, and what is at a.launch.yaml:2 was read before it; put it before "
       "all that names something\n"},
      {"- namespace: {name: a, tf: both}", {}, "a.launch.yaml:2: 'tf' cannot be 'both'; one of topics, frames\n"},
      {"- namespace: {path: a}", {}, ""},
  };
  for (const auto& [text, arguments, expected] : cases) {
    const std::string told = refused_names(text, arguments);
    if (expected.empty()) {
      EXPECT_NE(told, "") << text;
    } else {
      EXPECT_EQ(told, expected) << text;
    }
  }
}

}  // namespace
}  // namespace nacelle::launch
