// SPDX-License-Identifier: Apache-2.0
// Services between two containers that only the network joins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>

#include "mirrored_services.hpp"

namespace nacelle {
namespace {

using composition_interfaces::srv::ListNodes;
using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;
using test::AddTwoInts;
using test::Calling;
using test::MirroredContainer;
using test::MirrorServices;
using test::Offering;
using test::request_of;
using test::response_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(MirrorServices, are_called_and_answered_over_the_network) {
  there.load(adding, "adder");
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  for (int i = 0; i < 3; ++i) {
    const auto answer = calling.call(request_of(40, i));
    ASSERT_TRUE(answer) << i;
    EXPECT_EQ(answer->sum, 40 + i);
  }
  EXPECT_EQ(here.stats().calls, 3U);
  EXPECT_EQ(here.stats().answers, 3U);
  // They are counted when they are gone.
  EXPECT_TRUE(until([&] { return there.stats().requests == 3 && there.stats().replies == 3; }));
  EXPECT_EQ(here.stats().problems + there.stats().problems, 0U);
}

TEST_F(MirrorServices, stand_in_the_graph_below_their_nodes) {
  there.load(adding, "adder");
  here.load(calling, "caller");
  const auto info_of = [](MirroredContainer& at, const std::string& node) {
    std::optional<transport_dds::RemoteNodeInfo> info;
    at.mirror->look([&](const transport_dds::RemoteGraph& graph) { info = graph.node("/", node); });
    return info.value_or(transport_dds::RemoteNodeInfo{});
  };
  const transport_dds::NamesAndTypes expected{{"/add", {"example_interfaces/srv/AddTwoInts"}}};
  EXPECT_TRUE(until([&] { return info_of(here, "adder").servers == expected; }));
  EXPECT_TRUE(until([&] { return info_of(there, "caller").clients == expected; }));
  EXPECT_TRUE(until([&] { return info_of(here, "there").servers.contains("/there/_container/load_node"); }));
}

TEST_F(MirrorServices, have_the_ids_and_the_qos_of_rmw_cyclonedds) {
  there.load(adding, "adder");
  std::vector<transport_dds::RemoteEndpoint> ends;
  ASSERT_TRUE(until([&] {
    here.mirror->look([&](const transport_dds::RemoteGraph& graph) { ends = graph.ends_of_service("/add"); });
    return ends.size() == 2;
  }));
  EXPECT_NE(ends[0].is_writer, ends[1].is_writer);
  EXPECT_EQ(ends[0].user_data.service_id, ends[1].user_data.service_id);
  EXPECT_TRUE(ends[0].user_data.client_id.empty());
  // "1.10.": Cyclone's vendor id, with which the participant's prefix begins.
  EXPECT_TRUE(ends[0].user_data.service_id.starts_with(" 1.10.")) << ends[0].user_data.service_id;
  for (const auto& end : ends) {
    const auto& type = end.is_writer ? AddTwoInts::Response::message_type() : AddTwoInts::Request::message_type();
    EXPECT_EQ(end.user_data.type_hash, type.hash);
    EXPECT_EQ(end.qos.reliability(), Reliability::Reliable);
    EXPECT_EQ(end.qos.depth(), 10U);
  }
}

TEST_F(MirrorServices, of_this_process_are_called_first) {
  Offering<AddTwoInts> own{"/add", [](const auto&, auto& response) { response.sum = -1; }};
  here.load(calling, "caller");
  there.load(adding, "adder");
  ASSERT_TRUE(joined());
  const auto id = here.load(own, "own");
  EXPECT_EQ(calling.call(request_of(1, 2))->sum, -1);
  EXPECT_EQ(here.stats().calls, 0U);
  EXPECT_EQ(here.container().trigger(id, Transition::Deactivate).reason, "");
  EXPECT_EQ(calling.call(request_of(1, 2))->sum, 3) << "the local server does not answer while its node is inactive";
  ASSERT_TRUE(here.container().unload(id));
}

TEST_F(MirrorServices, notify_their_caller_when_they_end) {
  const auto id = there.load(pondering, "adder");
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  auto pending = calling.client->async_send_request(request_of(1, 2));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == 1; }));
  ASSERT_TRUE(there.container().unload(id));
  EXPECT_EQ(calling.answer_to(std::move(pending)), nullptr);
  EXPECT_FALSE(calling.client->service_is_ready());
  EXPECT_FALSE(calling.client->async_send_request(request_of(1, 2)).valid());
  EXPECT_EQ(here.stats().calls_failed, 1U);
}

TEST_F(MirrorServices, notify_their_caller_when_the_network_ends) {
  there.load(pondering, "adder");
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  auto pending = calling.client->async_send_request(request_of(1, 2));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == 1; }));
  here.mirror.reset();
  EXPECT_EQ(calling.answer_to(std::move(pending)), nullptr);
  EXPECT_FALSE(calling.client->service_is_ready());
  pondering.service->send_response(pondering.asked().at(0), response_of(3));
  there.mirror.reset();
  EXPECT_FALSE(pondering.service->send_response(pondering.asked().at(0), response_of(3)));
}

TEST_F(MirrorServices, may_answer_later_and_in_another_order) {
  there.load(pondering, "adder");
  here.load(calling, "caller");
  here.load(other, "other");
  ASSERT_TRUE(until([&] { return calling.client->service_is_ready() && other.client->service_is_ready(); }));
  auto first = calling.client->async_send_request(request_of(1, 0));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == 1; }));
  auto second = other.client->async_send_request(request_of(2, 0));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == 2; }));
  EXPECT_TRUE(pondering.service->send_response(pondering.asked()[1], response_of(20)));
  EXPECT_EQ(other.answer_to(std::move(second))->sum, 20);
  EXPECT_TRUE(pondering.service->send_response(pondering.asked()[0], response_of(10)));
  EXPECT_EQ(calling.answer_to(std::move(first))->sum, 10);
  EXPECT_EQ(here.stats().late, 0U) << "replies to the other client are no late ones";
}

TEST_F(MirrorServices, of_an_inactive_node_do_not_answer) {
  const auto id = there.load(adding, "adder", false);
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  auto unheard = calling.client->async_send_request(request_of(1, 2));
  ASSERT_TRUE(until([&] { return there.stats().requests_refused == 1; }));
  EXPECT_EQ(there.container().trigger(id, Transition::Activate).reason, "");
  EXPECT_EQ(calling.call(request_of(3, 4))->sum, 7);
  EXPECT_EQ(unheard.wait_for(0s), std::future_status::timeout) << "an earlier request is not executed later";
  EXPECT_EQ(adding.asked, 1);
  EXPECT_THAT(*there.problems.lock(), ElementsAre(HasSubstr("/adder is not active")));
}

TEST_F(MirrorServices, take_a_bounded_number_of_requests_and_their_callers_a_bounded_number_of_calls) {
  there.load(pondering, "adder");
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  constexpr std::size_t kServed = 256, kKept = 1000, kMore = 20;
  std::vector<Calling<AddTwoInts>::Future> pending;
  for (std::size_t i = 0; i < kKept + kMore; ++i) {
    pending.push_back(calling.client->async_send_request(request_of(static_cast<std::int64_t>(i), 0)));
    ASSERT_TRUE(pending.back().valid());
    if (i % 8 == 7) {
      ASSERT_TRUE(until([&] { return here.stats().calls == i + 1; })) << "no more than a writer keeps";
    }
  }
  EXPECT_TRUE(until([&] { return here.stats().calls_failed == kMore; })) << "the oldest calls fail";
  EXPECT_EQ(calling.answer_to(std::move(pending[0])), nullptr);
  EXPECT_EQ(pending[kMore].wait_for(0s), std::future_status::timeout);
  EXPECT_TRUE(until([&] { return there.stats().requests_refused == kKept + kMore - kServed; }))
      << there.stats().requests << " " << there.stats().requests_refused << " " << there.stats().broken << " "
      << there.stats().stray;
  EXPECT_EQ(there.stats().requests, kServed);
  EXPECT_THAT(*there.problems.lock(), ElementsAre(HasSubstr("wait for an answer")));
  // Calls that have room again are served, and an answer to a call that no longer waits does no harm.
  for (const auto& id : pondering.asked()) EXPECT_TRUE(pondering.service->send_response(id, response_of(5)));
  EXPECT_EQ(calling.answer_to(std::move(pending[kMore]))->sum, 5);
  EXPECT_TRUE(until([&] { return here.stats().late == kMore; }));
  auto again = calling.client->async_send_request(request_of(1, 1));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == kServed + 1; }));
  EXPECT_TRUE(pondering.service->send_response(pondering.asked().back(), response_of(2)));
  EXPECT_EQ(calling.answer_to(std::move(again))->sum, 2);
}

// --- refused calls ---------------------------------------------------------------------------------------------------

TEST_F(MirrorServices, a_refused_service_answers_callers_outside_in_the_words_that_were_given) {
  LoadNode::Response no;
  no.error_message = "not from outside";
  auto response = std::make_shared<msgs::AnyMessage>(LoadNode::Response::message_type());
  LoadNode::Response::message_type().copy_assign(response->get(), &no);
  MirroredContainer closed{"closed", {{"/closed/_container/load_node", response}}};
  Calling<LoadNode> load{"/closed/_container/load_node"}, load_within{"/closed/_container/load_node"};
  Calling<ListNodes> list{"/closed/_container/list_nodes"};
  closed.load(load_within, "within");
  here.load(load, "load");
  here.load(list, "list");
  ASSERT_TRUE(until([&] { return load.client->service_is_ready() && list.client->service_is_ready(); }));

  LoadNode::Request what;
  what.plugin_name = "nacelle::NoSuch";
  for (int i = 0; i < 2; ++i) {
    const auto loaded = load.call(what);
    ASSERT_TRUE(loaded);
    EXPECT_FALSE(loaded->success);
    EXPECT_EQ(loaded->error_message, "not from outside");
  }
  EXPECT_EQ(closed.stats().requests_refused, 2U);
  const auto listed = list.call({});
  ASSERT_TRUE(listed);
  EXPECT_THAT(listed->full_node_names, ElementsAre("/within"));
  const auto within = load_within.call(what);
  ASSERT_TRUE(within);
  EXPECT_THAT(within->error_message, HasSubstr("NoSuch")) << "a caller of the container itself is answered by it";
}

TEST_F(MirrorServices, load_and_unload_where_that_is_allowed) {
  Calling<LoadNode> load{"/open/_container/load_node"};
  Calling<UnloadNode> unload{"/open/_container/unload_node"};
  MirroredContainer open{"open"};
  here.load(load, "load");
  here.load(unload, "unload");
  const auto id = open.load(adding, "adder");
  ASSERT_TRUE(until([&] { return load.client->service_is_ready() && unload.client->service_is_ready(); }));
  LoadNode::Request what;
  what.plugin_name = "nacelle::NoSuch";
  const auto loaded = load.call(what);
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->success);
  EXPECT_THAT(loaded->error_message, HasSubstr("NoSuch")) << "the container's own words";
  UnloadNode::Request which;
  which.unique_id = id;
  const auto unloaded = unload.call(which);
  ASSERT_TRUE(unloaded);
  EXPECT_TRUE(unloaded->success) << unloaded->error_message;
  EXPECT_TRUE(open.container().list().empty());
}

}  // namespace
}  // namespace nacelle
