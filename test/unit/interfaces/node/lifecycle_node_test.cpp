// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/lifecycle_node.hpp"

#include <gtest/gtest.h>

#include <map>
#include <std_msgs/msg/string.hpp>

#include "support/recording_host.hpp"

namespace nacelle {
namespace {

using std_msgs::msg::String;

class Probe final : public LifecycleNode {
 public:
  explicit Probe(const NodeOptions& options) : LifecycleNode("probe", options) {
    out = create_publisher<String>("out", QoS(10));
    in = create_subscription<String>("in", QoS(10), [this](const String&) { ++heard; });
    timer = create_wall_timer(10ms, [this] { ++ticks; });
  }
  CallbackReturn answer(const char* name) {
    called += std::string(name) + " ";
    const auto it = answers.find(name);
    if (it == answers.end()) return CallbackReturn::SUCCESS;
    if (it->second == CallbackReturn::FAILURE) return refuse("refused");
    if (it->second == CallbackReturn::ERROR) throw std::runtime_error("broken");
    return it->second;
  }
  CallbackReturn on_configure(const State&) override { return answer("configure"); }
  CallbackReturn on_cleanup(const State&) override { return answer("cleanup"); }
  CallbackReturn on_activate(const State&) override { return answer("activate"); }
  CallbackReturn on_deactivate(const State&) override { return answer("deactivate"); }
  CallbackReturn on_shutdown(const State&) override { return answer("shutdown"); }
  CallbackReturn on_error(const State&) override { return answer("error"); }

  std::map<std::string, CallbackReturn> answers;
  std::string called;
  int heard = 0, ticks = 0;
  Publisher<String>::SharedPtr out;
  Subscription<String>::SharedPtr in;
  Timer::SharedPtr timer;
};

struct LifecycleNodeTest : ::testing::Test {
  test::RecordingContext context;
  Probe probe{NodeOptions{context}};
  StateId state() const { return probe.get_current_state().state(); }
};

// Every row of rcl_lifecycle's state machine that can be asked for: from, transition, callback's answer, to.
struct Row {
  std::vector<Transition> before;
  Transition transition;
  CallbackReturn answer;
  StateId expected;
};
const std::vector<Transition> kToInactive{Transition::Configure};
const std::vector<Transition> kToActive{Transition::Configure, Transition::Activate};
const Row kMachine[] = {
    {{}, Transition::Configure, CallbackReturn::SUCCESS, StateId::Inactive},
    {{}, Transition::Configure, CallbackReturn::FAILURE, StateId::Unconfigured},
    {{}, Transition::Configure, CallbackReturn::ERROR, StateId::Unconfigured},
    {{}, Transition::Shutdown, CallbackReturn::SUCCESS, StateId::Finalized},
    {{}, Transition::Shutdown, CallbackReturn::FAILURE, StateId::Finalized},
    {kToInactive, Transition::Cleanup, CallbackReturn::SUCCESS, StateId::Unconfigured},
    {kToInactive, Transition::Cleanup, CallbackReturn::FAILURE, StateId::Inactive},
    {kToInactive, Transition::Activate, CallbackReturn::SUCCESS, StateId::Active},
    {kToInactive, Transition::Activate, CallbackReturn::FAILURE, StateId::Inactive},
    {kToInactive, Transition::Activate, CallbackReturn::ERROR, StateId::Unconfigured},
    {kToInactive, Transition::Shutdown, CallbackReturn::SUCCESS, StateId::Finalized},
    {kToActive, Transition::Deactivate, CallbackReturn::SUCCESS, StateId::Inactive},
    {kToActive, Transition::Deactivate, CallbackReturn::FAILURE, StateId::Active},
    {kToActive, Transition::Deactivate, CallbackReturn::ERROR, StateId::Unconfigured},
    {kToActive, Transition::Shutdown, CallbackReturn::SUCCESS, StateId::Finalized},
};

TEST(LifecycleMachine, goes_where_ros_2_goes) {
  for (const auto& row : kMachine) {
    test::RecordingContext context;
    Probe probe{NodeOptions{context}};
    for (const auto t : row.before) ASSERT_TRUE(probe.trigger(t).success);
    probe.answers[to_text(row.transition)] = row.answer;
    const auto outcome = probe.trigger(row.transition);
    EXPECT_EQ(outcome.state, row.expected) << to_text(row.transition) << " " << static_cast<int>(row.answer);
    EXPECT_EQ(outcome.success, row.answer == CallbackReturn::SUCCESS);
    if (row.answer == CallbackReturn::FAILURE) { EXPECT_EQ(outcome.reason, "refused"); }
    if (row.answer == CallbackReturn::ERROR) { EXPECT_EQ(outcome.reason, "broken"); }
  }
}

TEST_F(LifecycleNodeTest, an_error_that_cannot_be_processed_finalizes) {
  probe.answers = {{"configure", CallbackReturn::ERROR}, {"error", CallbackReturn::FAILURE}};
  EXPECT_EQ(probe.trigger(Transition::Configure).state, StateId::Finalized);
  EXPECT_FALSE(probe.trigger(Transition::Configure).success);
}

TEST_F(LifecycleNodeTest, a_fault_is_legal_in_every_state) {
  for (const auto& before : {std::vector<Transition>{}, kToInactive, kToActive}) {
    Probe fresh{NodeOptions{context}.node_name("fresh")};
    for (const auto t : before) ASSERT_TRUE(fresh.trigger(t).success);
    const auto outcome = fresh.process_fault({"SERIAL_LOST", "the cable is out"});
    EXPECT_EQ(outcome.state, StateId::Unconfigured);
    EXPECT_EQ(outcome.reason, "SERIAL_LOST: the cable is out");
  }
}

TEST_F(LifecycleNodeTest, is_silent_and_deaf_while_it_is_not_active) {
  const auto live = [&] {
    context.inject("/in", String{});
    probe.out->publish(String{});
    context.advance(100ms);
  };
  live();
  ASSERT_TRUE(probe.trigger(Transition::Configure).success);
  live();
  EXPECT_EQ(probe.heard, 0);
  EXPECT_EQ(probe.ticks, 0);
  EXPECT_TRUE(context.published<String>("/out").empty());
  ASSERT_TRUE(probe.trigger(Transition::Activate).success);
  live();
  EXPECT_EQ(probe.heard, 1);
  EXPECT_EQ(probe.ticks, 10);
  EXPECT_EQ(context.published<String>("/out").size(), 1U);
  ASSERT_TRUE(probe.trigger(Transition::Deactivate).success);
  live();
  EXPECT_EQ(probe.heard, 1);
  EXPECT_EQ(probe.ticks, 10);
  EXPECT_EQ(context.published<String>("/out").size(), 1U);
  EXPECT_EQ(probe.out->counters().inactive, 3U);
}

TEST_F(LifecycleNodeTest, a_failed_activation_closes_the_gate_again) {
  ASSERT_TRUE(probe.trigger(Transition::Configure).success);
  probe.answers["activate"] = CallbackReturn::FAILURE;
  EXPECT_FALSE(probe.trigger(Transition::Activate).success);
  probe.out->publish(String{});
  EXPECT_TRUE(context.published<String>("/out").empty());
}

}  // namespace
}  // namespace nacelle
