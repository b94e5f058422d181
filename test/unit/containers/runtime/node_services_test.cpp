// SPDX-License-Identifier: Apache-2.0
// What ROS 2's tools expect of every node, asked as they do, of real components.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <lifecycle_msgs/srv/change_state.hpp>
#include <lifecycle_msgs/srv/get_available_states.hpp>
#include <lifecycle_msgs/srv/get_available_transitions.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>
#include <rcl_interfaces/msg/parameter_event.hpp>
#include <rcl_interfaces/srv/describe_parameters.hpp>
#include <rcl_interfaces/srv/get_parameter_types.hpp>
#include <rcl_interfaces/srv/get_parameters.hpp>
#include <rcl_interfaces/srv/list_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters_atomically.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <thread>
#include <type_description_interfaces/srv/get_type_description.hpp>

#include "asking.hpp"
#include "benchmark/support/recipe.hpp"
#include "container_fixture.hpp"
#include "nacelle/host/standard_interfaces.hpp"
#include "nacelle/runtime/foreign_component.hpp"

namespace nacelle::runtime {
namespace {

using lifecycle_msgs::srv::ChangeState;
using lifecycle_msgs::srv::GetAvailableStates;
using lifecycle_msgs::srv::GetAvailableTransitions;
using lifecycle_msgs::srv::GetState;
using rcl_interfaces::msg::ParameterEvent;
using rcl_interfaces::srv::DescribeParameters;
using rcl_interfaces::srv::GetParameters;
using rcl_interfaces::srv::GetParameterTypes;
using rcl_interfaces::srv::ListParameters;
using rcl_interfaces::srv::SetParameters;
using rcl_interfaces::srv::SetParametersAtomically;
using std_srvs::srv::SetBool;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::IsSubsetOf;
using ::testing::UnorderedElementsAreArray;
using type_description_interfaces::srv::GetTypeDescription;

constexpr std::uint8_t kNotSet = 0, kBool = 1, kInteger = 2, kDouble = 3, kText = 4;

rcl_interfaces::msg::Parameter parameter(const std::string& name, std::uint8_t type) {
  rcl_interfaces::msg::Parameter message;
  message.name = name;
  message.value.type = type;
  return message;
}
rcl_interfaces::msg::Parameter text(const std::string& name, const std::string& value) {
  auto message = parameter(name, kText);
  message.value.string_value = value;
  return message;
}
rcl_interfaces::msg::Parameter number(const std::string& name, double value) {
  auto message = parameter(name, kDouble);
  message.value.double_value = value;
  return message;
}

/// Descriptors on which a component says where it is, and waits for leave to go on.
class Doors {
 public:
  Doors() {
    EXPECT_EQ(::pipe(entered_.data()), 0);
    EXPECT_EQ(::pipe(release_.data()), 0);
  }
  ~Doors() {
    for (const int fd : {entered_[0], entered_[1], release_[0], release_[1]}) ::close(fd);
  }
  Doors(const Doors&) = delete;
  Doors& operator=(const Doors&) = delete;
  [[nodiscard]] std::map<std::string, ParameterValue> parameters(const std::string& sleep_in) const {
    return {{"sleep_in", sleep_in}, {"entered", std::int64_t{entered_[1]}}, {"release", std::int64_t{release_[0]}}};
  }
  void wait_for_entry() const {
    char byte = 0;
    ASSERT_EQ(::read(entered_[0], &byte, 1), 1);
  }
  void open() const {
    const char byte = 'o';
    ASSERT_EQ(::write(release_[1], &byte, 1), 1);
  }

 private:
  std::array<int, 2> entered_{}, release_{};
};

struct NodeServicesTest : ContainerTest {
  explicit NodeServicesTest(NodeInterfaces which = NodeInterfaces::All)
      : ContainerTest(ContainerOptions{.node_interfaces = which}) {}

  template <typename S>
  typename S::Response ask(const std::string& service, typename S::Request request = {}) {
    Call<S> call{container, service, std::move(request)};
    EXPECT_EQ(call.problem(), "");
    auto response = call.wait();
    EXPECT_TRUE(response) << service << " does not answer";
    return response ? std::move(*response) : typename S::Response{};
  }
  std::vector<rcl_interfaces::msg::SetParametersResult> set(const std::string& node,
                                                            std::vector<rcl_interfaces::msg::Parameter> parameters) {
    SetParameters::Request request;
    request.parameters.assign(parameters.begin(), parameters.end());
    const auto results = ask<SetParameters>(node + "/set_parameters", request).results;
    return {results.begin(), results.end()};
  }
  rcl_interfaces::msg::SetParametersResult set_atomically(const std::string& node,
                                                          std::vector<rcl_interfaces::msg::Parameter> parameters) {
    SetParametersAtomically::Request request;
    request.parameters.assign(parameters.begin(), parameters.end());
    return ask<SetParametersAtomically>(node + "/set_parameters_atomically", request).result;
  }
  std::string word(const std::string& node) {
    GetParameters::Request request;
    request.names = {"word"};
    const auto values = ask<GetParameters>(node + "/get_parameters", request).values;
    return values.empty() ? "(nothing)" : std::string{values.front().string_value};
  }
  std::string state(const std::string& node) { return ask<GetState>(node + "/get_state").current_state.label; }
  static ChangeState::Request to(std::uint8_t id, const std::string& label = "") {
    ChangeState::Request request;
    request.transition.id = id;
    request.transition.label = label;
    return request;
  }
  bool change(const std::string& node, std::uint8_t id, const std::string& label = "") {
    return ask<ChangeState>(node + "/change_state", to(id, label)).success;
  }
  std::vector<std::string> standard_names(const std::string& node) const {
    std::vector<std::string> names;
    for (const auto& service : container.services()) {
      if (service.node == node && service.is_standard && service.is_server && service.open)
        names.push_back(service.name);
    }
    return names;
  }
  ComponentInfo load_part(bench::Recipe& recipe, const std::string& name) {
    LoadRequest request;
    request.plugin = "nacelle::bench::Part";
    request.name = name;
    request.parameters = {{"recipe", static_cast<std::int64_t>(std::bit_cast<std::intptr_t>(&recipe))}};
    auto loaded = container.load(request);
    EXPECT_TRUE(loaded) << (loaded ? "" : loaded.error().text());
    return loaded ? loaded.value() : ComponentInfo{};
  }
};

// --- that they are there --------------------------------------------------------------------------------------------------

TEST_F(NodeServicesTest, are_there_while_a_node_is_loaded) {
  const auto talker = load("Talker");
  load("Caller");
  EXPECT_THAT(standard_names("/talker"), UnorderedElementsAreArray(standard_services("/talker", true)));
  EXPECT_THAT(standard_names("/caller"), UnorderedElementsAreArray(standard_services("/caller", false)))
      << "a plain node has no lifecycle";
  for (const auto& service : container.services()) {
    if (service.name == "/talker/enable") { EXPECT_FALSE(service.is_standard); }
  }
  ASSERT_TRUE(container.unload(talker.id));
  EXPECT_THAT(standard_names("/talker"), IsEmpty());
  EXPECT_FALSE(container.service_is_ready("/talker/get_state"));
  EXPECT_TRUE(container.service_is_ready("/caller/get_parameters"));
  for (const auto& end : container.endpoints()) EXPECT_NE(end.node, "/talker") << end.topic;
}

// `ros2 param list` asks every node that it finds, and waits for each.
TEST_F(NodeServicesTest, the_containers_own_node_has_parameters) {
  EXPECT_THAT(standard_names("/test"), UnorderedElementsAreArray(standard_services("/test", false)));
  EXPECT_THAT(ask<ListParameters>("/test/list_parameters").result.names, ElementsAre("use_sim_time"));
  GetParameters::Request request;
  request.names = {"use_sim_time"};
  const auto values = ask<GetParameters>("/test/get_parameters", request).values;
  ASSERT_EQ(values.size(), 1U);
  EXPECT_EQ(values[0].type, kBool);
  EXPECT_FALSE(values[0].bool_value);
  auto on = parameter("use_sim_time", kBool);
  on.value.bool_value = true;
  const auto refused = set("/test", {on, parameter("speed", kDouble)});
  ASSERT_EQ(refused.size(), 2U);
  EXPECT_FALSE(refused[0].successful);
  EXPECT_THAT(refused[0].reason, HasSubstr("read-only"));
  EXPECT_FALSE(refused[1].successful);
}

struct InAnIsolatedProcess : NodeServicesTest {
  InAnIsolatedProcess() : NodeServicesTest(NodeInterfaces::Isolated) {}
};

TEST_F(InAnIsolatedProcess, a_node_has_its_topics_and_all_services_but_the_lifecycles) {
  load("Talker");
  EXPECT_THAT(standard_names("/talker"), UnorderedElementsAreArray(standard_services("/talker", false)));
  EXPECT_THAT(standard_names("/test"), IsEmpty());
  std::vector<std::string> topics;
  for (const auto& end : container.endpoints()) {
    if (end.node == "/talker" && is_standard_topic(end.topic)) topics.push_back(end.topic);
  }
  EXPECT_THAT(topics, ElementsAre("/parameter_events", "/rosout"));
}

TEST_F(NodeServicesTest, take_no_thread_for_a_node) {
  // One that was joined may still be listed for a moment, before and after.
  const auto threads = [] {
    std::vector<std::string> ids;
    for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task"))
      ids.push_back(thread.path().filename());
    return ids;
  };
  load("Talker", {}, "first");
  const auto before = threads();
  load("Talker", {}, "second");
  load("Talker", {}, "third");
  const SystemClock real;
  const MonotonicTime limit = real.now() + 20s;
  while (!testing::Matches(IsSubsetOf(before))(threads()) && real.now() < limit) std::this_thread::yield();
  EXPECT_THAT(threads(), IsSubsetOf(before));
}

// --- parameters -----------------------------------------------------------------------------------------------------------

TEST_F(NodeServicesTest, parameters_are_got_in_the_order_that_is_asked_for) {
  load("Talker", {{"word", std::string{"moo"}}});
  GetParameters::Request request;
  request.names = {"word", "rate", "use_sim_time"};
  const auto values = ask<GetParameters>("/talker/get_parameters", request).values;
  ASSERT_EQ(values.size(), 3U);
  EXPECT_EQ(values[0].type, kText);
  EXPECT_EQ(values[0].string_value, "moo");
  EXPECT_EQ(values[1].type, kDouble);
  EXPECT_EQ(values[1].double_value, 100.0);
  EXPECT_EQ(values[2].type, kBool);
  GetParameterTypes::Request types;
  types.names = {"rate", "word"};
  EXPECT_THAT(ask<GetParameterTypes>("/talker/get_parameter_types", types).types, ElementsAre(kDouble, kText));
}

TEST_F(NodeServicesTest, an_unknown_parameter_leaves_the_answer_empty) {
  load("Talker");
  GetParameters::Request values;
  values.names = {"word", "wrod"};
  EXPECT_THAT(ask<GetParameters>("/talker/get_parameters", values).values, IsEmpty());
  GetParameterTypes::Request types;
  types.names = {"wrod", "word"};
  EXPECT_THAT(ask<GetParameterTypes>("/talker/get_parameter_types", types).types, IsEmpty());
  DescribeParameters::Request described;
  described.names = {"word", "wrod"};
  EXPECT_THAT(ask<DescribeParameters>("/talker/describe_parameters", described).descriptors, IsEmpty());
}

TEST_F(NodeServicesTest, parameters_are_described_with_type_and_limits) {
  load("Talker");
  DescribeParameters::Request request;
  request.names = {"rate", "use_sim_time"};
  const auto all = ask<DescribeParameters>("/talker/describe_parameters", request).descriptors;
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].name, "rate");
  EXPECT_EQ(all[0].type, kDouble);
  EXPECT_EQ(all[0].description, "Hz");
  EXPECT_FALSE(all[0].read_only);
  EXPECT_THAT(all[0].integer_range, IsEmpty());
  ASSERT_EQ(all[0].floating_point_range.size(), 1U);
  EXPECT_EQ(all[0].floating_point_range[0].from_value, 1.0);
  EXPECT_EQ(all[0].floating_point_range[0].to_value, 1000.0);
  EXPECT_TRUE(all[1].read_only);
}

/// Parameters with dots, one without a value, one of any type.
class Declaring final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    node.declare_parameter("pid.p", 1.0);
    node.declare_parameter("pid.limits.high", 5, {.integer_range = IntegerRange{0, 10, 5}});
    node.declare_parameter("empty", ParameterType::Integer);
    node.declare_parameter("loose", "anything", {.dynamic_typing = true});
    return nullptr;
  }
};

TEST_F(NodeServicesTest, parameters_are_listed_by_prefix_and_depth) {
  Declaring recipe;
  load_part(recipe, "base");
  const auto names = [&](std::initializer_list<const char*> prefixes, std::uint64_t depth) {
    ListParameters::Request request;
    request.prefixes.assign(prefixes.begin(), prefixes.end());
    request.depth = depth;
    const auto result = ask<ListParameters>("/base/list_parameters", request).result;
    std::string told;
    for (const auto& name : result.names) told += name + " ";
    for (const auto& prefix : result.prefixes) told += "[" + prefix + "]";
    return told;
  };
  EXPECT_EQ(names({}, 0), "empty loose pid.limits.high pid.p recipe use_sim_time [pid.limits][pid]");
  EXPECT_EQ(names({}, 1), "empty loose recipe use_sim_time ");
  EXPECT_EQ(names({}, 2), "empty loose pid.p recipe use_sim_time [pid]");
  EXPECT_EQ(names({"pid"}, 0), "pid.limits.high pid.p [pid.limits][pid]");
  EXPECT_EQ(names({"pid"}, 1), "pid.p [pid]");
  EXPECT_EQ(names({"pid.p", "loose"}, 1), "loose pid.p [pid]");
  EXPECT_EQ(names({"pi"}, 0), "");
}

TEST_F(NodeServicesTest, reports_a_parameter_without_a_value_as_not_set) {
  Declaring recipe;
  load_part(recipe, "base");
  GetParameterTypes::Request types;
  types.names = {"empty"};
  EXPECT_THAT(ask<GetParameterTypes>("/base/get_parameter_types", types).types, ElementsAre(kNotSet));
  GetParameters::Request values;
  values.names = {"empty", "loose"};
  EXPECT_THAT(ask<GetParameters>("/base/get_parameters", values).values, IsEmpty()) << "as rclcpp";
  DescribeParameters::Request described;
  described.names = {"empty", "loose", "pid.limits.high"};
  const auto all = ask<DescribeParameters>("/base/describe_parameters", described).descriptors;
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].type, kInteger);
  EXPECT_EQ(all[1].type, kText);
  EXPECT_TRUE(all[1].dynamic_typing);
  EXPECT_EQ(all[2].integer_range[0].step, 5U);
}

TEST_F(NodeServicesTest, parameters_are_set_one_by_one_with_rclcpps_words) {
  const auto talker = load("Talker");
  const auto results = set(
      "/talker", {text("word", "oink"), text("wrod", "x"), text("rate", "fast"), number("rate", 5000.0),
                  parameter("use_sim_time", kBool), parameter("word", kNotSet), parameter("word", 77), text("", "x")});
  ASSERT_EQ(results.size(), 8U);
  EXPECT_TRUE(results[0].successful);
  EXPECT_EQ(results[0].reason, "");
  EXPECT_EQ(results[1].reason, "parameter 'wrod' cannot be set because it was not declared");
  EXPECT_EQ(results[2].reason,
            "Wrong parameter type, parameter {rate} is of type {double}, setting it to {string} is not allowed.");
  EXPECT_THAT(results[3].reason, HasSubstr("Parameter {rate} doesn't comply with floating point range"));
  EXPECT_EQ(results[4].reason, "parameter 'use_sim_time' cannot be set because it is read-only");
  EXPECT_EQ(results[5].reason, "cannot undeclare a statically typed parameter");
  EXPECT_THAT(results[6].reason, HasSubstr("there is no type 77"));
  EXPECT_EQ(results[7].reason, "parameter name must not be empty");
  for (std::size_t i = 1; i < results.size(); ++i) EXPECT_FALSE(results[i].successful) << i;
  EXPECT_EQ(word("/talker"), "oink");
  EXPECT_EQ(container.request_of(talker.id)->parameters.at("word"), ParameterValue{std::string{"oink"}})
      << "kept for its restart";
}

TEST_F(NodeServicesTest, parameters_that_are_set_atomically_are_all_set_or_none) {
  load("Talker");
  EXPECT_TRUE(set_atomically("/talker", {text("word", "both"), number("rate", 10.0)}).successful);
  EXPECT_EQ(word("/talker"), "both");
  const auto range = set_atomically("/talker", {text("word", "half"), number("rate", 0.5)});
  EXPECT_FALSE(range.successful);
  EXPECT_THAT(range.reason, HasSubstr("floating point range"));
  EXPECT_EQ(set_atomically("/talker", {text("word", "half"), text("wrod", "x")}).reason,
            "One or more parameters were not declared before setting");
  EXPECT_THAT(set_atomically("/talker", {}).reason, HasSubstr("parameter list cannot be empty"));
  EXPECT_THAT(set_atomically("/talker", {text("word", "half"), parameter("rate", 99)}).reason, HasSubstr("no type 99"));
  EXPECT_EQ(word("/talker"), "both");
}

TEST_F(NodeServicesTest, a_transition_that_fails_leaves_its_reason_and_is_forgotten_when_it_succeeds) {
  std::atomic<int> told = 0;
  container.on_fault([&](const ComponentInfo&) { ++told; });
  const auto talker = load("Talker", {{"refuse", std::string("why not")}});
  static_cast<void>(container.trigger(talker.id, Transition::Configure));
  EXPECT_EQ(container.find("talker").value().fault.code, "TRANSITION_FAILED");
  ASSERT_EQ(container.faults().size(), 1U);
  EXPECT_EQ(container.faults()[0].callback, "transition on_configure");
  static_cast<void>(container.trigger(talker.id, Transition::Activate));
  EXPECT_EQ(container.faults().size(), 1U) << "an invalid transition runs no code of the component";
  EXPECT_EQ(told, 0) << "the caller got the reason; no fault policy runs";

  ASSERT_TRUE(set("/talker", {text("refuse", "")}).front().successful);
  bring_up(talker.id);
  EXPECT_EQ(container.find("talker").value().fault.code, "");
  EXPECT_EQ(container.faults().size(), 1U) << "the history stays";
}

// --- /parameter_events ----------------------------------------------------------------------------------------------------

/// Reads /parameter_events as text: "/base new rate:3 changed deleted".
class Events {
 public:
  explicit Events(Container& container) : events_(container.transport(), "/parameter_events", QoS(1000)) {}
  std::string next() {
    const ParameterEvent event = events_.next();
    std::string text = event.node;
    const auto append = [&](const char* what, const auto& parameters) {
      text += std::string{" "} + what;
      for (const auto& one : parameters) text += " " + one.name + ":" + std::to_string(one.value.type);
    };
    append("new", event.new_parameters);
    append("changed", event.changed_parameters);
    append("deleted", event.deleted_parameters);
    EXPECT_GT(event.stamp.sec, 0);
    return text;
  }

 private:
  TestSubscription<ParameterEvent> events_;
};

TEST_F(NodeServicesTest, publishes_parameter_changes_on_parameter_events) {
  Events events{container};
  Declaring recipe;
  load_part(recipe, "base");
  EXPECT_EQ(events.next(),
            "/base new empty:0 loose:4 pid.limits.high:2 pid.p:3 recipe:2 use_sim_time:1 changed deleted");
  ASSERT_TRUE(set("/base", {number("pid.p", 2.0)}).front().successful);
  EXPECT_EQ(events.next(), "/base new changed pid.p:3 deleted");
  ASSERT_FALSE(set("/base", {number("pid.limits.high", 2.0)}).front().successful);  // no other node is notified
  ASSERT_TRUE(set("/base", {parameter("loose", kNotSet)}).front().successful);
  EXPECT_EQ(events.next(), "/base new changed deleted loose:0");
  auto high = parameter("pid.limits.high", kInteger);
  high.value.integer_value = 10;
  ASSERT_TRUE(set_atomically("/base", {number("pid.p", 3.0), high}).successful);
  EXPECT_EQ(events.next(), "/base new changed pid.p:3 pid.limits.high:2 deleted");
  EXPECT_EQ(set("/base", {text("loose", "x")}).front().reason,
            "parameter 'loose' cannot be set because it was not declared");
}

/// Declares and sets a parameter of its own in a callback.
class SettingItself final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    return node.create_service<SetBool>("~/go", [&node](const SetBool::Request&, SetBool::Response& response) {
      if (!node.has_parameter("late")) node.declare_parameter("late", 1);
      response.success = node.set_parameter({"late", std::int64_t{2}}).successful;
    });
  }
};

TEST_F(NodeServicesTest, publishes_a_components_own_parameter_changes_too) {
  SettingItself recipe;
  const auto base = load_part(recipe, "base");
  bring_up(base.id);
  Events events{container};
  EXPECT_TRUE(ask<SetBool>("/base/go").success);
  EXPECT_EQ(events.next(), "/base new late:2 changed deleted");
  EXPECT_EQ(events.next(), "/base new changed late:2 deleted");
}

// --- lifecycle --------------------------------------------------------------------------------------------------------------

TEST_F(NodeServicesTest, shows_and_changes_a_lifecycle_state) {
  load("Talker");
  EXPECT_EQ(state("/talker"), "unconfigured");
  EXPECT_TRUE(change("/talker", 1));
  EXPECT_EQ(state("/talker"), "inactive");
  EXPECT_TRUE(change("/talker", 0, "activate"));
  EXPECT_EQ(ask<GetState>("/talker/get_state").current_state.id, 3);
  EXPECT_TRUE(change("/talker", 1, "deactivate")) << "a label comes before the id";
  EXPECT_TRUE(change("/talker", 6));
  EXPECT_EQ(state("/talker"), "finalized");
}

TEST_F(NodeServicesTest, a_transition_that_cannot_be_made_changes_nothing) {
  load("Talker");
  for (const std::uint8_t id : {0, 2, 3, 4, 6, 7, 8, 10, 77}) EXPECT_FALSE(change("/talker", id)) << int{id};
  for (const char* const label : {"activate", "transition_success", "configur"})
    EXPECT_FALSE(change("/talker", 1, label)) << label;
  EXPECT_EQ(state("/talker"), "unconfigured");
}

TEST_F(NodeServicesTest, a_transition_that_the_component_refuses_is_no_success) {
  load("Talker", {{"refuse", std::string{"no device"}}});
  EXPECT_FALSE(change("/talker", 1));
  EXPECT_EQ(state("/talker"), "unconfigured");
}

TEST_F(NodeServicesTest, lists_states_and_transitions_like_rcl_lifecycle) {
  load("Talker");
  std::string states;
  for (const auto& one : ask<GetAvailableStates>("/talker/get_available_states").available_states)
    states += std::to_string(one.id) + one.label + " ";
  EXPECT_EQ(states,
            "0unknown 1unconfigured 2inactive 3active 4finalized 10configuring 11cleaningup 12shuttingdown "
            "13activating 14deactivating 15errorprocessing ");
  const auto told = [&](const char* service) {
    std::vector<std::string> rows;
    for (const auto& one : ask<GetAvailableTransitions>(service).available_transitions)
      rows.push_back(std::to_string(one.transition.id) + " " + one.transition.label + " " + one.start_state.label +
                     "-" + one.goal_state.label);
    return rows;
  };
  EXPECT_THAT(told("/talker/get_available_transitions"),
              ElementsAre("1 configure unconfigured-configuring", "5 shutdown unconfigured-shuttingdown"));
  const auto graph = told("/talker/get_transition_graph");
  EXPECT_EQ(graph.size(), 25U);
  EXPECT_EQ(graph.at(1), "10 transition_success configuring-inactive");
  EXPECT_EQ(graph.back(), "62 transition_error errorprocessing-finalized");
}

TEST_F(NodeServicesTest, get_state_has_the_bytes_of_ros_2) {
  load("Talker");
  // test/data/ros2_wire/user_lc.jsonl, rr/lc_talker/get_stateReply: behind the call's header, without what pads the packet.
  const std::array<std::uint8_t, 21> recorded{0x01, 0,   0,   0,   0x0d, 0,   0,   0,   'u', 'n', 'c',
                                              'o',  'n', 'f', 'i', 'g',  'u', 'r', 'e', 'd', 0};
  const Bytes bytes = msgs::to_cdr(ask<GetState>("/talker/get_state"));
  const auto tail = std::vector<std::uint8_t>(bytes.end() - recorded.size(), bytes.end());
  EXPECT_TRUE(std::ranges::equal(tail, recorded));
}

// --- nodes do not wait for each other
// ---------------------------------------------------------------------------------------

TEST_F(NodeServicesTest, a_slow_transition_holds_up_no_question) {
  const Doors doors;
  load("Sleeper", doors.parameters("transition"));
  load("Talker");
  Call<ChangeState> configure{container, "/sleeper/change_state", to(1)};
  doors.wait_for_entry();
  EXPECT_EQ(state("/sleeper"), "configuring");
  GetParameters::Request asked;
  asked.names = {"sleep_in"};
  EXPECT_EQ(ask<GetParameters>("/sleeper/get_parameters", asked).values.at(0).string_value, "transition");
  EXPECT_EQ(ask<GetAvailableTransitions>("/sleeper/get_available_transitions").available_transitions.size(), 3U);
  EXPECT_EQ(state("/talker"), "unconfigured");
  EXPECT_TRUE(change("/talker", 1)) << "transitions of other nodes do not wait either";
  Call<ChangeState> activate{container, "/sleeper/change_state", to(3)};
  EXPECT_FALSE(configure.is_answered());
  doors.open();
  const auto configured = configure.wait(), activated = activate.wait();
  ASSERT_TRUE(configured && activated);
  EXPECT_TRUE(configured->success && activated->success) << "of one node, one after the other";
  EXPECT_EQ(state("/sleeper"), "active");
}

TEST_F(NodeServicesTest, refuses_excess_requests_at_once) {
  const Doors doors;
  load("Sleeper", doors.parameters("transition"));
  Call<ChangeState> configure{container, "/sleeper/change_state", to(1)};
  doors.wait_for_entry();
  std::vector<std::unique_ptr<Call<ChangeState>>> more;
  for (int i = 0; i < 40; ++i)
    more.push_back(std::make_unique<Call<ChangeState>>(container, "/sleeper/change_state", to(99)));
  const auto last = more.back()->wait();
  ASSERT_TRUE(last);
  EXPECT_FALSE(last->success);
  EXPECT_FALSE(more.front()->is_answered());
  doors.open();
  EXPECT_TRUE(configure.wait()->success);
  EXPECT_TRUE(more.front()->wait());
}

TEST_F(NodeServicesTest, notifies_callers_that_wait_for_an_unloaded_node) {
  const Doors doors;
  const auto sleeper = load("Sleeper", doors.parameters("transition"));
  Call<ChangeState> configure{container, "/sleeper/change_state", to(1)};
  doors.wait_for_entry();
  Call<ChangeState> waiting{container, "/sleeper/change_state", to(3)};
  auto unloaded = std::async(std::launch::async, [&] { return static_cast<bool>(container.unload(sleeper.id)); });
  doors.open();
  EXPECT_TRUE(unloaded.get());
  EXPECT_TRUE(configure.ends() && waiting.ends());  // answered before it went, or refused
  EXPECT_FALSE(container.service_is_ready("/sleeper/change_state"));
  Call<ChangeState> late{container, "/sleeper/change_state", to(1)};
  EXPECT_THAT(late.problem(), HasSubstr("no node of this process offers it"));
}

/// Requests its own transition in a callback, and waits there for the answer if requested.
class ChangingItself final : public bench::Recipe {
 public:
  std::shared_ptr<void> build(LifecycleNode& node) override {
    struct Made {
      Client<ChangeState>::SharedPtr client;
      Service<SetBool>::SharedPtr service;
    };
    auto made = std::make_shared<Made>();
    made->client = node.create_client<ChangeState>("~/change_state");
    made->service = node.create_service<SetBool>(
        "~/go", [this, client = made->client.get()](const SetBool::Request& request, SetBool::Response& response) {
          response.success = client->async_send_request(to_deactivate(), [this](const ChangeState::Response* answer) {
            done_.set_value(answer != nullptr && answer->success);
          });
          if (!request.data) return;
          try {
            static_cast<void>(client->async_send_request(to_deactivate()).wait_for(20s));
          } catch (const exceptions::WaitsForItself& e) { response.message = e.what(); }
        });
    return made;
  }
  std::future<bool> done() { return done_.get_future(); }

 private:
  static ChangeState::Request to_deactivate() {
    ChangeState::Request request;
    request.transition.label = "deactivate";
    return request;
  }
  std::promise<bool> done_;
};

TEST_F(NodeServicesTest, a_component_may_change_its_own_state_from_a_callback) {
  ChangingItself recipe;
  const auto base = load_part(recipe, "base");
  bring_up(base.id);
  auto done = recipe.done();
  SetBool::Request and_wait;
  and_wait.data = true;
  const auto response = ask<SetBool>("/base/go", and_wait);
  EXPECT_TRUE(response.success);
  EXPECT_NE(response.message, "") << "waiting for it there would never end";
  ASSERT_EQ(done.wait_for(20s), std::future_status::ready);
  EXPECT_TRUE(done.get());
  EXPECT_EQ(state("/base"), "inactive");
}

// --- types, and other processes ---------------------------------------------------------------------------------------------

TEST_F(NodeServicesTest, the_types_of_a_nodes_streams_are_described) {
  load("Talker");
  GetTypeDescription::Request request;
  request.type_hash = String::message_type().hash;
  request.include_type_sources = true;
  const auto told = ask<GetTypeDescription>("/talker/get_type_description", request);
  EXPECT_TRUE(told.successful) << told.failure_reason;
  EXPECT_EQ(told.type_description.type_description.type_name, "std_msgs/msg/String");
  ASSERT_EQ(told.type_sources.size(), 1U);
  EXPECT_THAT(told.type_sources[0].raw_file_contents, HasSubstr("string data"));
  request.type_hash = sensor_msgs::msg::Image::message_type().hash;
  EXPECT_EQ(ask<GetTypeDescription>("/talker/get_type_description", request).failure_reason,
            "Type not currently in use by this node");
}

class Elsewhere final : public ForeignComponent {
 public:
  ComponentInfo info() const override {
    ComponentInfo info;
    info.node = "/far/lidar";
    info.state = state_;
    info.managed = true;
    return info;
  }
  LoadRequest request() const override { return {}; }
  TransitionOutcome trigger(Transition transition) override {
    if (transition != Transition::Configure) return {false, state_, "not that"};
    state_ = StateId::Inactive;
    return {true, state_, ""};
  }
  void stop_what_moves() override {}
  void give_up_transitions_after(Duration) override {}
  UnloadOutcome unload() override { return {true, ""}; }

 private:
  std::atomic<StateId> state_{StateId::Unconfigured};
};

TEST_F(NodeServicesTest, of_a_node_in_another_process_the_lifecycle_is_offered) {
  const auto adopted = container.adopt(std::make_shared<Elsewhere>());
  ASSERT_TRUE(adopted);
  std::vector<std::string> names;
  for (const auto name : kLifecycleServices) names.push_back("/far/lidar/" + std::string(name));
  EXPECT_THAT(standard_names("/far/lidar"), UnorderedElementsAreArray(names));
  EXPECT_TRUE(change("/far/lidar", 1));
  EXPECT_EQ(state("/far/lidar"), "inactive");
  EXPECT_FALSE(change("/far/lidar", 3));
  ASSERT_TRUE(container.unload(adopted.value().id));
  EXPECT_THAT(standard_names("/far/lidar"), IsEmpty());
}

}  // namespace
}  // namespace nacelle::runtime
