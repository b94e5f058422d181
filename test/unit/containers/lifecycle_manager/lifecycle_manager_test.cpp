// SPDX-License-Identifier: Apache-2.0
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "support/manual_clock.hpp"

namespace nacelle::lifecycle_manager {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Names = std::vector<std::string>;

TEST(BringUpOrder, is_the_listed_order_without_dependencies) {
  EXPECT_EQ(bring_up_order({{"/c", {}}, {"/a", {}}, {"/b", {}}}).value(), (Names{"/c", "/a", "/b"}));
}

TEST(BringUpOrder, puts_dependencies_first_and_keeps_the_rest_as_listed) {
  EXPECT_EQ(
      bring_up_order({{"/ekf", {{"/odometry", ""}, {"/imu", ""}}}, {"/camera", {}}, {"/imu", {}}, {"/odometry", {}}})
          .value(),
      (Names{"/odometry", "/imu", "/ekf", "/camera"}));
}

TEST(BringUpOrder, names_the_nodes_of_a_cycle_and_where_it_stands) {
  const auto order =
      bring_up_order({{"/a", {{"/b", "x.yaml:3"}}}, {"/b", {{"/c", "x.yaml:7"}}}, {"/c", {{"/a", "x.yaml:9"}}}});
  ASSERT_FALSE(order);
  EXPECT_THAT(order.error().text(), HasSubstr("/a -> /b -> /c -> /a"));
  EXPECT_THAT(order.error().text(), HasSubstr("x.yaml:3"));
}

TEST(BringUpOrder, suggests_the_nearest_name_for_an_unknown_node) {
  const auto order = bring_up_order({{"/ekf", {{"/odometri", "x.yaml:3"}}}, {"/odometry", {}}});
  ASSERT_FALSE(order);
  EXPECT_THAT(order.error().text(), HasSubstr("did you mean '/odometry'?"));
}

TEST(BringUpOrder, keeps_every_dependency_for_random_acyclic_plans) {
  std::mt19937 random{20261121};
  for (int round = 0; round < 200; ++round) {
    std::vector<ManagedNode> nodes;
    for (int i = 0; i < 12; ++i) nodes.push_back({"/n" + std::to_string(i), {}});
    // Edges go from a higher number to a lower one, so there is no cycle; the listing is shuffled.
    for (int e = 0; e < 15; ++e) {
      const auto a = random() % 12, b = random() % 12;
      if (a > b) nodes[a].after.push_back({"/n" + std::to_string(b), ""});
    }
    std::shuffle(nodes.begin(), nodes.end(), random);
    const auto order = bring_up_order(nodes).value();
    EXPECT_EQ(std::set<std::string>(order.begin(), order.end()).size(), 12U);
    EXPECT_EQ(order, bring_up_order(nodes).value());
    const auto place = [&](const std::string& name) {
      return std::find(order.begin(), order.end(), name) - order.begin();
    };
    for (const auto& node : nodes) {
      for (const auto& dependency : node.after)
        EXPECT_LT(place(dependency.node), place(node.name)) << "seed 20261121, round " << round;
    }
  }
}

/// Nodes that do as they are told, but for one step.
struct Robot {
  std::map<std::string, StateId> states;
  Names log;
  std::string broken_node;
  Transition broken_transition = Transition::Configure;
  StateId state_after_failure = StateId::Unconfigured;

  TransitionOutcome trigger(const std::string& node, Transition transition) {
    log.push_back(node + " " + to_text(transition));
    if (node == broken_node && transition == broken_transition) {
      states[node] = state_after_failure;
      return {false, state_after_failure, "no such port: /dev/ttyUSB9"};
    }
    const StateId to = transition == Transition::Activate ? StateId::Active
                       : transition == Transition::Configure || transition == Transition::Deactivate
                           ? StateId::Inactive
                           : StateId::Unconfigured;
    states[node] = to;
    return {true, to, ""};
  }
};

struct LifecycleManagerTest : ::testing::Test {
  test::ManualClock clock;
  Robot robot;
  std::vector<Step> steps;
  LifecycleManager manager{{"/a", "/b", "/c"},
                           [this](const std::string& node, Transition t) { return robot.trigger(node, t); },
                           clock,
                           [this](const Step& step) { steps.push_back(step); }};
};

TEST_F(LifecycleManagerTest, goes_up_forwards_and_down_backwards) {
  const auto up = manager.startup();
  EXPECT_TRUE(up.success);
  EXPECT_THAT(up.activated, ElementsAre("/a", "/b", "/c"));
  EXPECT_THAT(robot.log,
              ElementsAre("/a configure", "/b configure", "/c configure", "/a activate", "/b activate", "/c activate"));
  robot.log.clear();
  const auto down = manager.shutdown();
  EXPECT_TRUE(down.success);
  EXPECT_THAT(down.activated, ElementsAre("/c", "/b", "/a"));
  EXPECT_THAT(robot.log,
              ElementsAre("/c deactivate", "/b deactivate", "/a deactivate", "/c cleanup", "/b cleanup", "/a cleanup"));
}

TEST_F(LifecycleManagerTest, undoes_what_it_did_when_a_configuration_fails) {
  robot.broken_node = "/b";
  const auto up = manager.startup();
  EXPECT_FALSE(up.success);
  EXPECT_THAT(up.problem.text(), HasSubstr("/b: could not configure: no such port: /dev/ttyUSB9"));
  EXPECT_THAT(robot.log, ElementsAre("/a configure", "/b configure", "/a cleanup"));
  EXPECT_TRUE(up.activated.empty());
}

TEST_F(LifecycleManagerTest, undoes_what_it_did_when_an_activation_fails) {
  robot.broken_node = "/b";
  robot.broken_transition = Transition::Activate;
  robot.state_after_failure = StateId::Inactive;
  EXPECT_FALSE(manager.startup().success);
  EXPECT_THAT(robot.log, ElementsAre("/a configure", "/b configure", "/c configure", "/a activate", "/b activate",
                                     "/a deactivate", "/c cleanup", "/b cleanup", "/a cleanup"));
  for (const auto& [node, state] : robot.states) EXPECT_EQ(state, StateId::Unconfigured) << node;
}

TEST_F(LifecycleManagerTest, tells_each_step_with_its_reason) {
  robot.broken_node = "/b";
  static_cast<void>(manager.startup());
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0].reason, "bring-up");
  EXPECT_EQ(steps[1].reason, "no such port: /dev/ttyUSB9");
  EXPECT_EQ(steps[2].reason, "undo: /b could not configure");
}

TEST_F(LifecycleManagerTest, goes_on_shutting_down_after_a_failure_and_reports_the_first) {
  static_cast<void>(manager.startup());
  robot.broken_node = "/b";
  robot.broken_transition = Transition::Deactivate;
  robot.state_after_failure = StateId::Active;
  robot.log.clear();
  const auto down = manager.shutdown();
  EXPECT_FALSE(down.success);
  EXPECT_THAT(down.problem.text(), HasSubstr("/b: could not deactivate"));
  EXPECT_THAT(robot.log, ElementsAre("/c deactivate", "/b deactivate", "/a deactivate", "/c cleanup", "/a cleanup"));
}

}  // namespace
}  // namespace nacelle::lifecycle_manager
