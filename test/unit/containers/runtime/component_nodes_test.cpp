// SPDX-License-Identifier: Apache-2.0
// Components that make nodes beside themselves.
#include <gmock/gmock.h>

#include <future>
#include <rcl_interfaces/srv/get_parameters.hpp>
#include <rcl_interfaces/srv/set_parameters.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "asking.hpp"
#include "container_fixture.hpp"

namespace nacelle::runtime {
namespace {

using rcl_interfaces::srv::GetParameters;
using rcl_interfaces::srv::SetParameters;
using std_srvs::srv::SetBool;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct ComponentNodesTest : ContainerTest {
  ComponentNodesTest() : ContainerTest(ContainerOptions{.node_interfaces = NodeInterfaces::All}) {}
  ComponentInfo twins() { return container.find("twins").value(); }
  std::vector<std::string> endpoints_of(const std::string& node) {
    std::vector<std::string> topics;
    for (const auto& end : container.endpoints()) {
      if (end.node == node && end.topic.starts_with("/" + node.substr(1) + "/")) topics.push_back(end.topic);
    }
    std::ranges::sort(topics);
    return topics;
  }
  std::string ask(const std::string& node) {
    Call<SetBool> call{container, node + "/ask", {}};
    const auto response = call.wait();
    return response ? std::string(response->message) : call.problem();
  }
  std::string greeting_of(const std::string& node) {
    GetParameters::Request request;
    request.names = {"greeting"};
    Call<GetParameters> call{container, node + "/get_parameters", request};
    const auto response = call.wait();
    return response && !response->values.empty() ? std::string(response->values[0].string_value) : call.problem();
  }
  bool greet_with(const std::string& node, const std::string& text) {
    SetParameters::Request request;
    request.parameters.resize(1);
    request.parameters[0].name = "greeting";
    request.parameters[0].value.type = 4;
    request.parameters[0].value.string_value = text;
    Call<SetParameters> call{container, node + "/set_parameters", request};
    const auto response = call.wait();
    return response && response->results.size() == 1 && response->results[0].successful;
  }
};

TEST_F(ComponentNodesTest, a_node_beside_the_component_is_a_node_with_its_own_name_topics_services_and_parameters) {
  const auto info = load("Twins");
  EXPECT_THAT(info.other_nodes, ElementsAre("/twin"));
  EXPECT_EQ(container.list().size(), 1U) << "it is no component";
  EXPECT_EQ(info.id, 1U);
  EXPECT_EQ(container.find("/twin").value().id, info.id);
  EXPECT_THAT(endpoints_of("/twin"), ElementsAre("/twin/in", "/twin/out"));
  Ear out(container, "/twin/out");
  say("/twin/in", "world");
  EXPECT_EQ(out.next(), "hello world") << "always active, whatever the state of the component";
  EXPECT_EQ(ask("/twin"), "/twin");
  EXPECT_EQ(greeting_of("/twin"), "hello");
  EXPECT_TRUE(greet_with("/twin", "good morning"));
  say("/twin/in", "world");
  EXPECT_EQ(out.next(), "good morning world");
  std::vector<CallbackReport> callbacks;
  container.report_callbacks(callbacks);
  EXPECT_EQ(std::ranges::count(callbacks, "/twin", &CallbackReport::node), 2) << "a subscription and a service";
}

TEST_F(ComponentNodesTest, nodes_come_and_go_while_the_component_runs) {
  bring_up(load("Twins").id);
  Ear done(container, "/done"), out(container, "/late/out");
  say("/orders", "make late");
  EXPECT_EQ(done.next(), "make late");
  say("/late/in", "world");
  EXPECT_EQ(out.next(), "hello world");
  EXPECT_EQ(ask("/late"), "/late");
  EXPECT_EQ(greeting_of("/late"), "hello");
  EXPECT_THAT(twins().other_nodes, ElementsAre("/twin", "/late"));
  say("/orders", "destroy late");
  EXPECT_EQ(done.next(), "destroy late");
  EXPECT_THAT(twins().other_nodes, ElementsAre("/twin"));
  EXPECT_THAT(endpoints_of("/late"), IsEmpty());
  EXPECT_THAT(ask("/late"), HasSubstr("no node of this process offers it"));
  say("/orders", "make late");
  EXPECT_EQ(done.next(), "make late") << "its name is free again";
  EXPECT_EQ(out.next(), "hello world");
  EXPECT_EQ(greeting_of("/late"), "hello");
}

TEST_F(ComponentNodesTest, an_unload_ends_them_all_and_frees_their_names) {
  bring_up(load("Twins").id);
  Ear done(container, "/done");
  say("/orders", "make late");
  EXPECT_EQ(done.next(), "make late");
  EXPECT_TRUE(container.unload(twins().id).value().image_closed);
  EXPECT_FALSE(is_mapped("nacelle_test_twins.so"));
  for (const char* node : {"/twins", "/twin", "/late"}) EXPECT_THAT(endpoints_of(node), IsEmpty()) << node;
  load("Twins");
}

TEST_F(ComponentNodesTest, names_are_of_one_node_each) {
  load("Twins");
  LoadRequest second;
  second.plugin = "nacelle::test::Twins";
  second.name = "others";
  const auto refused = container.load(second);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().text(), HasSubstr("a node /twin is loaded already"));
  EXPECT_FALSE(container.find("others")) << "nothing of it is left";
  second.name_space = "/left";
  ASSERT_TRUE(container.load(second)) << "other nodes are in the namespace of their component";
  EXPECT_THAT(container.find("/left/others").value().other_nodes, ElementsAre("/left/twin"));
  bring_up(twins().id);
  Ear done(container, "/done");
  say("/orders", "make twins");
  EXPECT_THAT(done.next(), HasSubstr("a node /twins is loaded already"));
}

TEST_F(ComponentNodesTest, a_rule_that_renames_the_component_renames_no_other_node) {
  LoadRequest request;
  request.plugin = "nacelle::test::Twins";
  request.remaps = {parse_remap_rule("__node:=renamed").value(), parse_remap_rule("/twin/out:=/elsewhere").value()};
  const auto loaded = container.load(request);
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(loaded.value().node, "/renamed");
  EXPECT_THAT(loaded.value().other_nodes, ElementsAre("/twin"));
  EXPECT_THAT(loaded.value().declared->used_remaps, ElementsAre(false, true));
  Ear elsewhere(container, "/elsewhere");
  say("/twin/in", "world");
  EXPECT_EQ(elsewhere.next(), "hello world");
}

TEST_F(ComponentNodesTest, a_constructor_that_throws_leaves_none_of_them) {
  LoadRequest request;
  request.plugin = "nacelle::test::Twins";
  request.parameters = {{"fails", true}};
  EXPECT_FALSE(container.load(request));
  EXPECT_THAT(endpoints_of("/twin"), IsEmpty());
  load("Twins");
}

TEST_F(ComponentNodesTest, an_exception_in_one_of_them_is_a_fault_of_the_component) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });
  bring_up(load("Twins").id);
  say("/twin/in", "throw");
  const auto info = told.get_future().get();
  EXPECT_EQ(info.node, "/twins");
  EXPECT_EQ(info.fault.text, "a twin does not like that word");
  EXPECT_EQ(info.state, StateId::Unconfigured);
  EXPECT_EQ(container.faults().at(0).callback, "subscription /twin/in");
}

TEST_F(ComponentNodesTest, the_library_stays_while_a_node_of_it_outlives_its_component) {
  const auto info = load("Twins");
  bring_up(info.id);
  Ear done(container, "/done");
  say("/orders", "keep leaked");
  EXPECT_EQ(done.next(), "keep leaked");
  const auto outcome = container.unload(info.id).value();
  EXPECT_FALSE(outcome.image_closed);
  EXPECT_EQ(outcome.held_by, "a node that it made and has not destroyed");
  EXPECT_TRUE(is_mapped("nacelle_test_twins.so"));
  EXPECT_NE(ask("/leaked"), "/leaked") << "it answers no more";
  EXPECT_EQ(container.abandoned(), 1U);

  mouths.clear();  // or it would get the last order, too
  load("Twins", {}, "again");
  bring_up(container.find("again").value().id);
  say("/orders", "let go");
  EXPECT_EQ(done.next(), "let go");
  EXPECT_THAT(endpoints_of("/leaked"), IsEmpty());
  EXPECT_TRUE(container.unload(container.find("again").value().id).value().image_closed);
  EXPECT_THAT(container.kept_images(), IsEmpty());
  EXPECT_FALSE(is_mapped("nacelle_test_twins.so"));
}

}  // namespace
}  // namespace nacelle::runtime
