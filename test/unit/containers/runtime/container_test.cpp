// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/container.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <future>

#include "ear.hpp"
#include "nacelle/runtime/plugin_library.hpp"

namespace nacelle::runtime {
namespace {

using std_msgs::msg::String;
using ::testing::HasSubstr;

struct ContainerTest : ::testing::Test {
  SystemClock clock;
  Container container{{.name = "test", .component_path = {NACELLE_TEST_PLUGINS}}, clock};

  ComponentInfo load(const std::string& plugin, std::map<std::string, ParameterValue> parameters = {},
                     const std::string& name = "") {
    LoadRequest request;
    request.plugin = "nacelle::test::" + plugin;
    request.name = name;
    request.parameters = std::move(parameters);
    auto loaded = container.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    return loaded ? loaded.value() : ComponentInfo{};
  }
  void bring_up(std::uint64_t id) {
    EXPECT_EQ(container.trigger(id, Transition::Configure).reason, "");
    EXPECT_EQ(container.trigger(id, Transition::Activate).reason, "");
  }
  void say(const std::string& topic, const std::string& text) {
    auto writer =
        container.transport().create_writer({topic, &String::message_type(), QoS(10).transient_local(), "/mouth"});
    Block* const block = writer->borrow();
    static_cast<String*>(block->message)->data = text;
    writer->publish(*block);
    mouths.push_back(std::move(writer));
  }
  static bool is_mapped(const std::string& file) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      if (line.find(file) != std::string::npos) return true;
    }
    return false;
  }
  std::vector<std::unique_ptr<Writer>> mouths;
};

TEST_F(ContainerTest, loads_runs_and_unloads_a_component_and_its_image_is_gone) {
  Ear ticks(container, "/ticks", QoS(10));
  const auto talker = load("Talker");
  EXPECT_EQ(talker.node, "/talker");
  EXPECT_EQ(talker.state, StateId::Unconfigured);
  bring_up(talker.id);
  EXPECT_EQ(container.find("talker").value().state, StateId::Active);
  EXPECT_EQ(ticks.next(), "tick");
  EXPECT_TRUE(is_mapped("nacelle_test_talker.so"));
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

TEST_F(ContainerTest, a_late_joiner_hears_the_latched_word) {
  const auto talker = load("Talker", {{"word", std::string("early")}});
  bring_up(talker.id);
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  EXPECT_EQ(heard.next(), "early");
}

TEST_F(ContainerTest, a_service_is_called_and_its_absence_is_told) {
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  say("/ask", "?");
  EXPECT_EQ(heard.next(), "nobody there");
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
  const char* says;
};

TEST_F(ContainerTest, whatever_cannot_be_loaded_is_named_and_leaves_nothing) {
  const BadLoad cases[] = {
      {"nacelle::test::Thrower", {}, "no such calibration file: /nowhere"},
      {"nacelle::test::WrongAbi", {}, "component ABI"},
      {"nacelle::test::Talkre", {}, "did you mean 'nacelle::test::Talker'?"},
      {"nacelle::test::Talker", {{"rate", 0.5}}, "0.5 is not in 1 to 1000"},
      {"nacelle::test::Talker",
       {{"rate", std::string("fast")}},
       "parameter 'rate' is double but was given string (fast)"},
  };
  for (const auto& bad : cases) {
    LoadRequest request;
    request.plugin = bad.plugin;
    request.parameters = bad.parameters;
    const auto loaded = container.load(request);
    ASSERT_FALSE(loaded) << bad.plugin;
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
  EXPECT_THAT(again.error().text(), HasSubstr("/talker is loaded already"));
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
