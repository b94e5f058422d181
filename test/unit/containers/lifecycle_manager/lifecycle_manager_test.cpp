// SPDX-License-Identifier: Apache-2.0
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <random>
#include <set>

#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/name_fault.hpp"
#include "support/manual_clock.hpp"

namespace nacelle::lifecycle_manager {
namespace {

using ::testing::ElementsAre;
using Names = std::vector<std::string>;

Names names_of(const Result<std::vector<ManagedNode>, Problem>& order) {
  Names names;
  for (const auto& node : order.value()) names.push_back(node.name);
  return names;
}

TEST(BringUpOrder, is_the_listed_order_without_dependencies) {
  EXPECT_EQ(names_of(bring_up_order({{"/c", {}}, {"/a", {}}, {"/b", {}}})), (Names{"/c", "/a", "/b"}));
}

TEST(BringUpOrder, puts_dependencies_first_and_keeps_the_rest_as_listed) {
  EXPECT_EQ(names_of(bring_up_order(
                {{"/ekf", {{"/odometry", ""}, {"/imu", ""}}}, {"/camera", {}}, {"/imu", {}}, {"/odometry", {}}})),
            (Names{"/odometry", "/imu", "/ekf", "/camera"}));
}

TEST(BringUpOrder, names_the_nodes_of_a_cycle_and_where_it_stands) {
  const auto order =
      bring_up_order({{"/a", {{"/b", "x.yaml:3"}}}, {"/b", {{"/c", "x.yaml:7"}}}, {"/c", {{"/a", "x.yaml:9"}}}});
  ASSERT_FALSE(order);
  EXPECT_EQ(order.error().code, LifecycleFault::OrderCircle);
  EXPECT_EQ(order.error().where, Place("x.yaml:3"));
  EXPECT_EQ(order.error().value, "/a");
  EXPECT_EQ(order.error().text(),
            "x.yaml:3: these nodes wait for each other: /a -> /b -> /c -> /a; remove one of their after: entries");
}

TEST(BringUpOrder, suggests_the_nearest_name_for_an_unknown_node) {
  const auto order = bring_up_order({{"/ekf", {{"/odometri", "x.yaml:3"}}}, {"/odometry", {}}});
  ASSERT_FALSE(order);
  EXPECT_EQ(order.error().code, NameFault::Unknown);
  EXPECT_EQ(order.error().where, Place("x.yaml:3"));
  EXPECT_EQ(order.error().value, "/odometri");
  EXPECT_EQ(order.error().way_out, "did you mean '/odometry'?");
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
    const auto order = names_of(bring_up_order(nodes));
    EXPECT_EQ(std::set<std::string>(order.begin(), order.end()).size(), 12U);
    EXPECT_EQ(order, names_of(bring_up_order(nodes)));
    const auto place = [&](const std::string& name) {
      return std::find(order.begin(), order.end(), name) - order.begin();
    };
    for (const auto& node : nodes) {
      for (const auto& dependency : node.after)
        EXPECT_LT(place(dependency.node), place(node.name)) << "seed 20261121, round " << round;
    }
  }
}

/// Nodes that follow every request except one step.
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

/// Work that has been started ends when the manager waits: the last piece first, one at each wait. Time is simulated.
class BackwardCrew final : public Crew {
 public:
  explicit BackwardCrew(test::ManualClock& clock) : clock_(clock) {}
  void start(std::function<void()> work) override {
    waiting_.push_back(std::move(work));
    most_at_once = std::max(most_at_once, waiting_.size());
  }
  void wait(Duration at_most) override {
    clock_.advance(std::min<Duration>(at_most, 100ms));
    if (on_wait) on_wait();
    if (waiting_.empty() || held) return;
    const auto work = std::move(waiting_.back());
    waiting_.pop_back();
    work();
  }
  std::function<void()> on_wait;
  bool held = false;
  std::size_t most_at_once = 0;

 private:
  test::ManualClock& clock_;
  std::vector<std::function<void()>> waiting_;
};

struct LifecycleManagerTest : ::testing::Test {
  test::ManualClock clock;
  Robot robot;
  BackwardCrew crew{clock};
  std::vector<Step> steps;
  Names told, waits;
  MonotonicTime waits_told_at{};
  std::string interrupted;

  LifecycleManager manager_of(const std::vector<ManagedNode>& nodes) {
    Hooks hooks;
    hooks.trigger = [this](const std::string& node, Transition t) { return robot.trigger(node, t); };
    hooks.state = [this](const std::string& node) {
      return robot.states.count(node) != 0 ? robot.states[node] : StateId::Unknown;
    };
    hooks.interrupted = [this] { return interrupted; };
    hooks.on_step = [this](const Step& step) {
      steps.push_back(step);
      told.push_back(std::string{to_text(step.transition)} + " " + step.node);
    };
    hooks.on_wait = [this](const std::string& node, const std::string& text) {
      waits.push_back(node + " " + text);
      waits_told_at = clock.now();
    };
    return {bring_up_order(nodes).value(), hooks, clock};
  }
  LifecycleManager chain() { return manager_of({{"/a", {}}, {"/b", {{"/a", "x:1"}}}, {"/c", {{"/b", "x:2"}}}}); }
};

TEST_F(LifecycleManagerTest, goes_up_in_the_order_of_after_and_down_backwards) {
  auto manager = chain();
  const auto up = manager.startup(crew);
  EXPECT_TRUE(up.success);
  EXPECT_THAT(up.activated, ElementsAre("/a", "/b", "/c"));
  EXPECT_THAT(robot.log,
              ElementsAre("/c configure", "/b configure", "/a configure", "/a activate", "/b activate", "/c activate"));
  EXPECT_THAT(told,
              ElementsAre("configure /a", "configure /b", "configure /c", "activate /a", "activate /b", "activate /c"));
  robot.log.clear();
  const auto at_rest = manager.deactivate();
  EXPECT_TRUE(at_rest.success);
  EXPECT_THAT(at_rest.activated, ElementsAre("/c", "/b", "/a"));
  EXPECT_TRUE(manager.cleanup().success);
  EXPECT_THAT(robot.log,
              ElementsAre("/c deactivate", "/b deactivate", "/a deactivate", "/c cleanup", "/b cleanup", "/a cleanup"));
}

TEST_F(LifecycleManagerTest, brings_up_independent_nodes_in_parallel_and_reports_in_the_plans_order) {
  auto manager = manager_of({{"/a", {}}, {"/b", {}}, {"/d", {{"/a", ""}, {"/b", ""}}}, {"/c", {}}});
  EXPECT_THAT(manager.startup(crew).activated, ElementsAre("/a", "/b", "/d", "/c"));
  EXPECT_EQ(crew.most_at_once, 4U);
  // The transitions end in another order than they are reported: /d waits for both.
  EXPECT_THAT(robot.log, ElementsAre("/c configure", "/d configure", "/b configure", "/a configure", "/c activate",
                                     "/b activate", "/a activate", "/d activate"));
  EXPECT_THAT(told, ElementsAre("configure /a", "configure /b", "configure /d", "configure /c", "activate /a",
                                "activate /b", "activate /d", "activate /c"));
}

TEST_F(LifecycleManagerTest, rolls_back_when_a_configuration_fails) {
  robot.broken_node = "/b";
  auto manager = chain();
  const auto up = manager.startup(crew);
  EXPECT_FALSE(up.success);
  EXPECT_EQ(up.problem.code, LifecycleFault::TransitionFailed);
  EXPECT_EQ(up.problem.where, Place::of_node("/b"));
  EXPECT_EQ(up.problem.value, "configure");
  EXPECT_EQ(
      up.problem.text(),
      "node /b: could not configure: no such port: /dev/ttyUSB9; nothing was left running: everything started so far "
      "was rolled back");
  EXPECT_THAT(robot.log, ElementsAre("/c configure", "/b configure", "/a configure", "/c cleanup", "/a cleanup"));
  EXPECT_TRUE(up.activated.empty());
}

TEST_F(LifecycleManagerTest, rolls_back_when_an_activation_fails) {
  robot.broken_node = "/b";
  robot.broken_transition = Transition::Activate;
  robot.state_after_failure = StateId::Inactive;
  auto manager = chain();
  EXPECT_FALSE(manager.startup(crew).success);
  robot.log.erase(robot.log.begin(), robot.log.begin() + 3);
  EXPECT_THAT(robot.log,
              ElementsAre("/a activate", "/b activate", "/a deactivate", "/c cleanup", "/b cleanup", "/a cleanup"));
  for (const auto& [node, state] : robot.states) EXPECT_EQ(state, StateId::Unconfigured) << node;
}

TEST_F(LifecycleManagerTest, names_the_first_of_several_failures_in_the_plans_order) {
  Hooks hooks;
  hooks.trigger = [](const std::string& node, Transition) {
    return TransitionOutcome{false, StateId::Unconfigured, "broken " + node};
  };
  LifecycleManager manager{bring_up_order({{"/a", {}}, {"/b", {}}}).value(), hooks, clock};
  EXPECT_EQ(manager.startup(crew).problem.where, Place::of_node("/a"));
}

TEST_F(LifecycleManagerTest, tells_each_step_with_its_reason) {
  robot.broken_node = "/b";
  auto manager = chain();
  static_cast<void>(manager.startup(crew));
  ASSERT_EQ(steps.size(), 5U);
  EXPECT_EQ(steps[0].reason, "bring-up");
  EXPECT_EQ(steps[1].reason, "no such port: /dev/ttyUSB9");
  EXPECT_EQ(steps[3].reason, "undo: node /b could not configure");
}

TEST_F(LifecycleManagerTest, continues_without_an_optional_node_and_no_node_waits_for_it) {
  robot.broken_node = "/b";
  robot.broken_transition = Transition::Activate;
  robot.state_after_failure = StateId::Inactive;
  auto manager = manager_of({{"/a", {}}, {"/b", {}, true, false}, {"/c", {{"/b", ""}}}});
  const auto up = manager.startup(crew);
  EXPECT_TRUE(up.success) << up.problem.text();
  EXPECT_THAT(up.activated, ElementsAre("/a", "/c"));
  EXPECT_EQ(robot.states["/b"], StateId::Unconfigured);
  const auto failed = std::find_if(steps.begin(), steps.end(), [](const Step& step) { return !step.success; });
  ASSERT_NE(failed, steps.end());
  EXPECT_TRUE(failed->left_out);
}

TEST_F(LifecycleManagerTest, configures_only_what_is_not_to_be_activated) {
  auto manager = manager_of({{"/a", {}, false}, {"/b", {{"/a", ""}}}});
  EXPECT_THAT(manager.startup(crew).activated, ElementsAre("/b"));
  EXPECT_EQ(robot.states["/a"], StateId::Inactive);
  EXPECT_TRUE(manager.deactivate().success);
  EXPECT_TRUE(manager.cleanup().success);
  EXPECT_EQ(robot.states["/a"], StateId::Unconfigured);
}

TEST_F(LifecycleManagerTest, waits_for_a_condition_and_reports_it_after_three_seconds) {
  const MonotonicTime begin = clock.now();
  auto manager = manager_of({{"/lidar", {}}, {"/ekf", {{"/lidar", "x:7", "first_message(/scan)", [&] {
                                                          return clock.now() - begin < Duration{5s}
                                                                     ? std::string{"no message yet"}
                                                                     : std::string{};
                                                        }}}}});
  EXPECT_TRUE(manager.startup(crew).success);
  EXPECT_GE(clock.now() - begin, Duration{5s});
  EXPECT_THAT(waits, ElementsAre("/ekf waits for first_message(/scan) of /lidar: no message yet (at most 10 s)"));
  EXPECT_GE(waits_told_at - begin, Duration{3s});
}

TEST_F(LifecycleManagerTest, gives_up_waiting_after_the_timeout_and_undoes) {
  auto manager = manager_of(
      {{"/lidar", {}}, {"/ekf", {{"/lidar", "x:7", "first_message(/scan)", [] { return "no message yet"; }, 3s}}}});
  const auto up = manager.startup(crew);
  EXPECT_FALSE(up.success);
  EXPECT_EQ(up.problem.code, LifecycleFault::TransitionFailed);
  EXPECT_EQ(up.problem.where, Place::of_node("/ekf"));
  EXPECT_EQ(up.problem.value, "activate");
  EXPECT_EQ(up.problem.what, "could not activate: x:7: waited 3 s for first_message(/scan) of /lidar: no message yet");
  for (const auto& [node, state] : robot.states) EXPECT_EQ(state, StateId::Unconfigured) << node;
}

TEST_F(LifecycleManagerTest, asks_for_a_condition_only_once_the_node_is_active) {
  bool asked_too_early = false;
  auto manager = manager_of({{"/lidar", {}}, {"/ekf", {{"/lidar", "", "first_message(/scan)", [&] {
                                                          asked_too_early |= robot.states["/lidar"] != StateId::Active;
                                                          return std::string{};
                                                        }}}}});
  EXPECT_TRUE(manager.startup(crew).success);
  EXPECT_FALSE(asked_too_early);
}

TEST_F(LifecycleManagerTest, says_which_step_does_not_return) {
  crew.held = true;
  const MonotonicTime begin = clock.now();
  crew.on_wait = [this] { crew.held = waits.empty(); };
  auto manager = manager_of({{"/imu", {}}});
  EXPECT_TRUE(manager.startup(crew).success);
  EXPECT_THAT(waits, ElementsAre("/imu is still in on_configure"));
  EXPECT_GE(waits_told_at - begin, Duration{3s}) << "a driver gives up on a missing device after two";
}

TEST_F(LifecycleManagerTest, ends_at_once_when_interrupted_and_undoes) {
  crew.on_wait = [this] { interrupted = clock.now() >= MonotonicTime{3s} ? "interrupted by SIGINT" : ""; };
  auto manager = manager_of({{"/lidar", {}}, {"/ekf", {{"/lidar", "", "tf(a->b)", [] { return "no such frame"; }}}}});
  const auto up = manager.startup(crew);
  EXPECT_FALSE(up.success);
  EXPECT_EQ(up.problem.code, LifecycleFault::Interrupted);
  EXPECT_EQ(up.problem.what, "interrupted by SIGINT");
  EXPECT_EQ(robot.states["/lidar"], StateId::Unconfigured);
}

TEST_F(LifecycleManagerTest, continues_the_shutdown_after_a_failure_and_reports_the_first) {
  auto manager = chain();
  static_cast<void>(manager.startup(crew));
  robot.broken_node = "/b";
  robot.broken_transition = Transition::Deactivate;
  robot.state_after_failure = StateId::Active;
  robot.log.clear();
  const auto down = manager.deactivate();
  EXPECT_FALSE(down.success);
  EXPECT_EQ(down.problem.code, LifecycleFault::TransitionFailed);
  EXPECT_EQ(down.problem.where, Place::of_node("/b"));
  EXPECT_EQ(down.problem.value, "deactivate");
  EXPECT_TRUE(manager.cleanup().success);
  EXPECT_THAT(robot.log, ElementsAre("/c deactivate", "/b deactivate", "/a deactivate", "/c cleanup", "/a cleanup"));
}

TEST_F(LifecycleManagerTest, leaves_alone_on_the_way_down_what_others_have_stopped_or_taken_out) {
  auto manager = chain();
  static_cast<void>(manager.startup(crew));
  robot.states["/b"] = StateId::Unconfigured;
  robot.states.erase("/c");
  robot.log.clear();
  EXPECT_THAT(manager.deactivate().activated, ElementsAre("/a"));
  EXPECT_TRUE(manager.cleanup().success);
  EXPECT_THAT(robot.log, ElementsAre("/a deactivate", "/a cleanup"));
}

TEST(ThreadCrew, works_beside_the_caller_and_wakes_it) {
  std::atomic<int> done{0};
  {
    ThreadCrew crew;
    for (int i = 0; i < 20; ++i) crew.start([&] { ++done; });
    while (done != 20) crew.wait(10s);
  }
  EXPECT_EQ(done, 20);
}

}  // namespace
}  // namespace nacelle::lifecycle_manager
