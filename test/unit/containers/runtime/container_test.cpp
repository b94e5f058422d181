// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/container.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <mutex>
#include <optional>
#include <semaphore>

#include "container_fixture.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/runtime/plugin_fault.hpp"

namespace nacelle::runtime {
namespace {

using ::testing::HasSubstr;

TEST_F(ContainerTest, loads_each_class_of_a_library_with_several) {
  const ComponentInfo first = load("First"), second = load("Second");
  EXPECT_EQ(first.node, "/first");
  EXPECT_FALSE(first.managed);
  EXPECT_EQ(second.node, "/second");
  EXPECT_TRUE(second.managed);
  EXPECT_EQ(first.library, second.library);
}

TEST_F(ContainerTest, loads_runs_and_unloads_a_component_and_its_image_is_gone) {
  std::optional<Ear> ticks(std::in_place, container, "/ticks", QoS(10));
  const auto talker = load("Talker");
  EXPECT_EQ(talker.node, "/talker");
  EXPECT_EQ(talker.state, StateId::Unconfigured);
  bring_up(talker.id);
  EXPECT_EQ(container.find("talker").value().state, StateId::Active);
  EXPECT_EQ(ticks->next(), "tick");
  EXPECT_TRUE(is_mapped("nacelle_test_talker.so"));
  ticks.reset();  // it may hold more of them
  const auto outcome = container.unload(talker.id);
  ASSERT_TRUE(outcome);
  EXPECT_EQ(outcome.value().held_by, "");
  EXPECT_TRUE(outcome.value().image_closed);
  EXPECT_FALSE(is_mapped("nacelle_test_talker.so"));
  EXPECT_TRUE(container.list().empty());
}

TEST_F(ContainerTest, an_image_stays_while_its_messages_are_held_and_goes_afterwards) {
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  const auto talker = load("Talker");
  bring_up(talker.id);
  EXPECT_EQ(heard.next(), "hello");
  const auto outcome = container.unload(talker.id).value();
  EXPECT_FALSE(outcome.image_closed);
  EXPECT_EQ(outcome.held_by, "1 message of /words");
  EXPECT_TRUE(is_mapped("nacelle_test_talker.so"));
  EXPECT_TRUE(container.unload(listener.id).value().image_closed);
  static_cast<void>(load("Listener"));  // the next load sweeps
  EXPECT_FALSE(is_mapped("nacelle_test_talker.so"));
}

TEST_F(ContainerTest, two_instances_share_an_image_until_the_last_is_gone) {
  const auto one = load("Talker", {}, "one");
  const auto two = load("Talker", {}, "two");
  EXPECT_THAT(container.unload(one.id).value().held_by, HasSubstr("/two"));
  EXPECT_TRUE(container.unload(two.id).value().image_closed);
}

TEST_F(ContainerTest, a_late_joiner_gets_the_latched_message) {
  const auto talker = load("Talker", {{"word", std::string("early")}});
  bring_up(talker.id);
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  EXPECT_EQ(heard.next(), "early");
}

TEST_F(ContainerTest, a_service_is_called_and_its_absence_is_reported) {
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  say("/ask", "?");
  EXPECT_EQ(heard.next(), "no server");
  const auto talker = load("Talker");
  bring_up(talker.id);
  EXPECT_EQ(heard.next(), "hello");
  say("/ask", "?");
  EXPECT_EQ(heard.next(), "answer hello");
}

TEST_F(ContainerTest, a_component_that_throws_is_faulted_with_its_reason_and_the_others_go_on) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });
  Ear ticks(container, "/ticks", QoS(1000));
  const auto listener = load("Listener");
  const auto talker = load("Talker");
  bring_up(listener.id);
  bring_up(talker.id);
  say("/words", "throw");
  const auto info = told.get_future().get();
  EXPECT_EQ(info.node, "/listener");
  EXPECT_EQ(info.fault.code, "EXCEPTION");
  EXPECT_EQ(info.fault.text, "cannot bear that word");
  EXPECT_EQ(info.state, StateId::Unconfigured);
  ASSERT_EQ(container.faults().size(), 1U);
  EXPECT_EQ(container.faults()[0].callback, "subscription /words");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(ticks.next(), "tick");
  bring_up(listener.id);
  EXPECT_EQ(container.find("listener").value().fault.code, "") << "a new configure ends the fault";
}

TEST_F(ContainerTest, a_fault_that_a_component_reports_runs_error_processing) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });
  const auto listener = load("Listener");
  bring_up(listener.id);
  say("/words", "fault");
  EXPECT_EQ(told.get_future().get().fault.code, "BAD_WORD");
}

TEST_F(ContainerTest, an_open_fault_changes_no_state_applies_no_policy_and_ends_when_the_component_says_so) {
  std::promise<FaultEvent> began, ended;
  container.on_fault([&](const ComponentInfo& info) { ADD_FAILURE() << info.node << " is faulted"; });
  container.on_open_fault([&](const FaultEvent& event) { (event.lasted ? ended : began).set_value(event); });
  const auto sleeper = load("Sleeper");
  bring_up(sleeper.id);
  say("/words", "open");
  EXPECT_EQ(began.get_future().get().code, "CABLE");
  const auto open = container.find("sleeper").value();
  EXPECT_EQ(open.state, StateId::Active);
  EXPECT_EQ(open.fault.code, "");
  ASSERT_EQ(open.open_faults.size(), 1U);
  EXPECT_EQ(open.open_faults[0].text, "it is pulled");
  ASSERT_EQ(container.faults().size(), 1U);
  EXPECT_TRUE(container.faults()[0].is_open_fault);
  EXPECT_FALSE(container.faults()[0].lasted);

  say("/words", "close");
  EXPECT_EQ(ended.get_future().get().text, "it is pulled");
  EXPECT_TRUE(container.find("sleeper").value().open_faults.empty());
  EXPECT_TRUE(container.faults()[0].lasted) << "the history says how long it lasted";
  container.on_open_fault({});
  container.on_fault({});
}

TEST_F(ContainerTest, a_reader_that_keeps_everything_faults_a_publisher_whose_pool_must_not_run_dry) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });
  LoadRequest request;
  request.plugin = "nacelle::test::Talker";
  request.qos = {{"/ticks", true, [](const QoS& qos) { return QoS(qos).when_dry(PoolPolicy::Fail); }}};
  const auto talker = container.load(request);
  ASSERT_TRUE(talker);
  struct Ears final : ReadyListener {
    void on_ready() noexcept override { arrived.release(); }
    std::counting_semaphore<> arrived{0};
  } ears;
  const auto reader =
      container.transport().create_reader({"/ticks", &String::message_type(), QoS(1), "/keeper"}, Taking::Share, &ears);
  std::vector<Block*> kept;
  bring_up(talker.value().id);
  auto fault = told.get_future();
  while (fault.wait_for(0s) != std::future_status::ready) {
    if (!ears.arrived.try_acquire_for(100ms)) continue;
    if (Block* const block = reader->take()) kept.push_back(block);
  }
  EXPECT_EQ(fault.get().fault.code, "POOL_DRY");
  EXPECT_EQ(container.find("talker").value().state, StateId::Unconfigured);
  for (Block* block : kept) drop_reference(*block);
}

TEST_F(ContainerTest, keeps_and_reports_a_fault_during_a_successful_transition) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });
  const auto talker = load("Talker", {{"fault_while_activating", true}});
  bring_up(talker.id);
  EXPECT_EQ(told.get_future().get().fault.code, "LINE_LOST");
  EXPECT_EQ(container.find("talker").value().fault.code, "LINE_LOST");
}

TEST_F(ContainerTest, a_component_that_refused_a_transition_can_still_fail_for_good) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });
  const auto listener = load("Listener");
  bring_up(listener.id);
  EXPECT_FALSE(container.trigger(listener.id, Transition::Configure).success);
  say("/words", "throw");
  EXPECT_EQ(told.get_future().get().fault.code, "EXCEPTION");
}

TEST_F(ContainerTest, reports_the_states_of_a_transition_and_of_a_fault_in_order) {
  std::mutex mutex;
  std::string states;
  container.on_state([&](const StateChange& change) {
    const std::lock_guard lock(mutex);
    states += std::string(states.empty() ? "" : " ") + to_text(change.to);
  });
  std::promise<void> told;
  container.on_fault([&](const ComponentInfo&) { told.set_value(); });
  const auto listener = load("Listener");
  bring_up(listener.id);
  say("/words", "throw");
  told.get_future().wait();
  const std::lock_guard lock(mutex);
  EXPECT_EQ(states, "configuring inactive activating active errorprocessing unconfigured");
}

TEST_F(ContainerTest, reports_changes_made_by_any_caller) {
  std::atomic<int> changes = 0;
  container.on_change([&] { ++changes; });
  const auto talker = load("Talker");
  EXPECT_EQ(changes, 1);
  bring_up(talker.id);
  EXPECT_EQ(changes, 3);
  ASSERT_TRUE(container.unload(talker.id));
  EXPECT_EQ(changes, 4);
}

TEST_F(ContainerTest, a_refused_transition_keeps_its_reason) {
  const auto talker = load("Talker", {{"refuse", std::string("why not")}});
  const auto outcome = container.trigger(talker.id, Transition::Configure);
  EXPECT_FALSE(outcome.success);
  EXPECT_EQ(outcome.state, StateId::Unconfigured);
  EXPECT_EQ(outcome.reason, "parameter refuse: is 'why not'; leave it empty");
  const auto not_allowed = container.trigger(talker.id, Transition::Activate);
  EXPECT_EQ(not_allowed.reason, "cannot activate from state unconfigured; allowed is configure, shutdown");
}

TEST_F(ContainerTest, an_exception_in_a_transition_is_an_error_with_its_text) {
  const auto talker = load("Talker", {{"refuse", std::string("throw")}});
  const auto outcome = container.trigger(talker.id, Transition::Configure);
  EXPECT_EQ(outcome.reason, "the device burns");
  EXPECT_EQ(outcome.state, StateId::Unconfigured);
}

struct BadLoad {
  const char* plugin;
  std::map<std::string, ParameterValue> parameters;
  PluginFault fault;
  const char* says;
};

TEST_F(ContainerTest, a_component_that_cannot_be_loaded_is_named_and_leaves_nothing) {
  const BadLoad cases[] = {
      {"nacelle::test::Thrower", {}, PluginFault::FailedConstructor, "no such calibration file: /nowhere"},
      {"nacelle::test::Talkre", {}, PluginFault::UnknownClass, "did you mean 'nacelle::test::Talker'?"},
      {"nacelle::test::Talker", {{"rate", 0.5}}, PluginFault::FailedConstructor, "0.5 is not in 1 to 1000"},
      {"nacelle::test::Talker",
       {{"rate", std::string("fast")}},
       PluginFault::FailedConstructor,
       "parameter 'rate' is double but was given string (fast)"},
  };
  for (const auto& bad : cases) {
    LoadRequest request;
    request.plugin = bad.plugin;
    request.parameters = bad.parameters;
    const auto loaded = container.load(request);
    ASSERT_FALSE(loaded) << bad.plugin;
    EXPECT_EQ(loaded.error().code, bad.fault) << bad.plugin;
    EXPECT_EQ(loaded.error().where, Place(bad.plugin));
    EXPECT_EQ(loaded.error().value, bad.plugin);
    EXPECT_THAT(loaded.error().text(), HasSubstr(bad.says));
  }
  EXPECT_TRUE(container.list().empty());
  EXPECT_FALSE(is_mapped("nacelle_test_thrower.so"));
}

TEST_F(ContainerTest, a_name_that_is_taken_is_refused) {
  load("Talker");
  LoadRequest request;
  request.plugin = "nacelle::test::Talker";
  const auto again = container.load(request);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, NameFault::Taken);
  EXPECT_EQ(again.error().value, "/talker");
  EXPECT_EQ(container.list().size(), 1U);
}

TEST_F(ContainerTest, a_name_that_no_node_may_have_is_refused) {
  LoadRequest request;
  request.plugin = "nacelle::test::Talker";
  request.name = "4 talkers";
  const auto malformed = container.load(request);
  ASSERT_FALSE(malformed);
  EXPECT_EQ(malformed.error().code, NameFault::Invalid);
  EXPECT_EQ(malformed.error().value, "4 talkers");

  request.name = std::string(256, 'x');
  const auto too_long = container.load(request);
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().code, NameFault::Invalid);
  EXPECT_EQ(too_long.error().value, std::string(60, 'x') + "...");
  EXPECT_EQ(too_long.error().what, "its name has 256 bytes; at most 255 are allowed");
  EXPECT_TRUE(container.list().empty());
}

TEST_F(ContainerTest, remaps_and_namespaces_move_topics) {
  LoadRequest request;
  request.plugin = "nacelle::test::Talker";
  request.name_space = "/robot1";
  request.remaps = {make_remap_rule("words", "speech").value()};
  const auto loaded = container.load(request);
  ASSERT_TRUE(loaded);
  Ear speech(container, "/robot1/speech");
  bring_up(loaded.value().id);
  EXPECT_EQ(speech.next(), "hello");
}

}  // namespace
}  // namespace nacelle::runtime
