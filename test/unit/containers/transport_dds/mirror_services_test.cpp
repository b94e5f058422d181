// SPDX-License-Identifier: Apache-2.0
// Services between two containers that only the network joins, and between one and what anybody may send.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <example_interfaces/srv/add_two_ints.hpp>
#include <lifecycle_msgs/srv/change_state.hpp>
#include <lifecycle_msgs/srv/get_available_transitions.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>
#include <random>

#include "mirrored_container.hpp"
#include "recordings.hpp"
#include "support/manual_clock.hpp"

namespace nacelle {
namespace {

using composition_interfaces::srv::ListNodes;
using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;
using example_interfaces::srv::AddTwoInts;
using lifecycle_msgs::srv::GetState;
using test::Calling;
using test::MirroredContainer;
using test::Offering;
using test::Pondering;
using test::RawEnd;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

AddTwoInts::Request request_of(std::int64_t a, std::int64_t b) {
  AddTwoInts::Request request;
  request.a = a;
  request.b = b;
  return request;
}
AddTwoInts::Response response_of(std::int64_t sum) {
  AddTwoInts::Response response;
  response.sum = sum;
  return response;
}
void add(const AddTwoInts::Request& request, AddTwoInts::Response& response) { response.sum = request.a + request.b; }

std::unique_ptr<RawEnd> raw_client(transport_dds::Participant& participant, const std::string& id = {},
                                   std::optional<std::string> hash = {}) {
  return std::make_unique<RawEnd>(participant, AddTwoInts::Request::message_type(),
                                  AddTwoInts::Response::message_type(), "/add", false, id, std::move(hash));
}
std::unique_ptr<RawEnd> raw_server(transport_dds::Participant& participant, const std::string& id = {},
                                   std::optional<std::string> hash = {}) {
  return std::make_unique<RawEnd>(participant, AddTwoInts::Request::message_type(),
                                  AddTwoInts::Response::message_type(), "/add", true, id, std::move(hash));
}

/// The header and the sum of a reply.
std::pair<transport_dds::CallHeader, std::int64_t> read_reply(const Bytes& bytes) {
  Bytes scratch;
  const auto call = transport_dds::read_call(bytes, scratch);
  AddTwoInts::Response response;
  if (!call || !msgs::from_cdr(call->message, response)) return {{}, -1};
  return {call->header, response.sum};
}

class MirrorServices : public ::testing::Test {
 public:
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here.bell.until(holds);
  }
  /// The caller here and the server there know each other, on both sides.
  [[nodiscard]] bool joined() {
    return until([&] {
      std::size_t ends = 0;
      there.mirror->look([&](const transport_dds::RemoteGraph& graph) { ends = graph.ends_of_service("/add").size(); });
      return ends != 0 && ends % 2 == 0 && calling.client->service_is_ready();
    });
  }

  // What the components consist of, before the containers.
  Offering<AddTwoInts> adding{"/add", add};
  Pondering<AddTwoInts> pondering{"/add"};
  Calling<AddTwoInts> calling{"/add"}, other{"/add"};
  MirroredContainer here{"here"}, there{"there"};
};

// --- between two containers ------------------------------------------------------------------------------------------

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
  EXPECT_EQ(calling.call(request_of(1, 2))->sum, 3) << "it answers nobody while its node is not active";
  ASSERT_TRUE(here.container().unload(id));
}

TEST_F(MirrorServices, tell_their_caller_when_they_go) {
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

TEST_F(MirrorServices, tell_their_caller_when_the_network_ends) {
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

TEST_F(MirrorServices, of_a_node_that_is_not_active_answer_nobody) {
  const auto id = there.load(adding, "adder", false);
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  auto unheard = calling.client->async_send_request(request_of(1, 2));
  ASSERT_TRUE(until([&] { return there.stats().requests_refused == 1; }));
  EXPECT_EQ(there.container().trigger(id, Transition::Activate).reason, "");
  EXPECT_EQ(calling.call(request_of(3, 4))->sum, 7);
  EXPECT_EQ(unheard.wait_for(0s), std::future_status::timeout) << "what was asked before is not done later";
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
  EXPECT_TRUE(until([&] { return here.stats().calls_failed == kMore; })) << "the oldest are told";
  EXPECT_EQ(calling.answer_to(std::move(pending[0])), nullptr);
  EXPECT_EQ(pending[kMore].wait_for(0s), std::future_status::timeout);
  EXPECT_TRUE(until([&] { return there.stats().requests_refused == kKept + kMore - kServed; }))
      << there.stats().requests << " " << there.stats().requests_refused << " " << there.stats().broken << " "
      << there.stats().stray;
  EXPECT_EQ(there.stats().requests, kServed);
  EXPECT_THAT(*there.problems.lock(), ElementsAre(HasSubstr("wait for an answer")));
  // Those that have room again are served, and an answer to a call that nobody waits for any more harms nobody.
  for (const auto& id : pondering.asked()) EXPECT_TRUE(pondering.service->send_response(id, response_of(5)));
  EXPECT_EQ(calling.answer_to(std::move(pending[kMore]))->sum, 5);
  EXPECT_TRUE(until([&] { return here.stats().late == kMore; }));
  auto again = calling.client->async_send_request(request_of(1, 1));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == kServed + 1; }));
  EXPECT_TRUE(pondering.service->send_response(pondering.asked().back(), response_of(2)));
  EXPECT_EQ(calling.answer_to(std::move(again))->sum, 2);
}

// --- load_node -------------------------------------------------------------------------------------------------------

TEST_F(MirrorServices, load_and_unload_nothing_for_callers_outside) {
  Calling<LoadNode> load{"/there/_container/load_node"};
  Calling<UnloadNode> unload{"/there/_container/unload_node"};
  Calling<ListNodes> list{"/there/_container/list_nodes"};
  const auto id = there.load(adding, "adder");
  MirroredContainer asking{"asking"};
  asking.load(load, "load");
  asking.load(unload, "unload");
  asking.load(list, "list");
  ASSERT_TRUE(until([&] { return load.client->service_is_ready() && unload.client->service_is_ready(); }));
  LoadNode::Request what;
  what.plugin_name = "nacelle::bench::Part";
  const auto loaded = load.call(what);
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->success);
  EXPECT_THAT(loaded->error_message, HasSubstr("network: {allow_load: true}"));
  UnloadNode::Request which;
  which.unique_id = id;
  const auto unloaded = unload.call(which);
  ASSERT_TRUE(unloaded);
  EXPECT_FALSE(unloaded->success);
  EXPECT_THAT(unloaded->error_message, HasSubstr("allow_load"));
  ASSERT_TRUE(until([&] { return list.client->service_is_ready(); }));
  const auto listed = list.call({});
  ASSERT_TRUE(listed);
  EXPECT_THAT(listed->full_node_names, ElementsAre("/adder")) << "which is always answered";
}

TEST_F(MirrorServices, load_and_unload_where_that_is_allowed) {
  Calling<LoadNode> load{"/open/_container/load_node"};
  Calling<UnloadNode> unload{"/open/_container/unload_node"};
  MirroredContainer open{"open", true};
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

// --- what the network may bring --------------------------------------------------------------------------------------

TEST_F(MirrorServices, answer_a_client_that_does_not_name_itself) {
  there.load(adding, "adder");
  const auto participant = test::make_participant();
  const auto client = raw_client(*participant);
  client->make_reply_reader();
  ASSERT_TRUE(client->matched());
  client->say({99, 7}, request_of(40, 2));
  EXPECT_EQ(read_reply(client->next()), (std::pair{transport_dds::CallHeader{99, 7}, std::int64_t{42}}));
}

TEST(MirrorServicesInTime, wait_for_the_reader_of_a_client_that_names_itself_but_not_for_ever) {
  test::ManualClock network;  // stands still: so does the patience of 100 ms
  Offering<AddTwoInts> adding{"/add", add};
  MirroredContainer there{"there", false, &network};
  there.load(adding, "adder");
  const auto participant = test::make_participant();
  const auto client = raw_client(*participant, " 1.10.0.0.0.0.0.0.0.0.0.0.0.0.0.1");
  ASSERT_TRUE(client->matched());
  client->say({99, 1}, request_of(1, 1));
  ASSERT_TRUE(there.bell.until([&] { return adding.asked == 1; }));
  network.advance(99ms);
  client->make_reply_reader();
  EXPECT_EQ(read_reply(client->next()).second, 2) << "it came late, and has its reply";

  const auto deaf = raw_client(*participant, " 1.10.0.0.0.0.0.0.0.0.0.0.0.0.0.2");
  ASSERT_TRUE(deaf->matched());
  deaf->say({98, 1}, request_of(1, 1));
  ASSERT_TRUE(there.bell.until([&] { return adding.asked == 2; }));
  EXPECT_EQ(there.stats().replies_dropped, 0U);
  ASSERT_TRUE(there.bell.until([&] {
    network.advance(10ms);
    return there.stats().replies_dropped == 1;
  }));
  EXPECT_EQ(there.stats().replies, 1U);
}

TEST_F(MirrorServices, drop_the_reply_to_a_client_that_has_gone) {
  there.load(pondering, "adder");
  const auto participant = test::make_participant();
  auto client = raw_client(*participant);
  ASSERT_TRUE(client->matched());
  client->say({99, 1}, request_of(1, 1));
  ASSERT_TRUE(until([&] { return pondering.asked().size() == 1; }));
  client.reset();
  ASSERT_TRUE(until([&] {
    std::size_t ends = 0;
    there.mirror->look([&](const transport_dds::RemoteGraph& graph) { ends = graph.ends_of_service("/add").size(); });
    return ends == 0;
  }));
  pondering.service->send_response(pondering.asked()[0], response_of(2));
  // Its end is told to the reader and to the discovery apart; without a reader that reply goes nowhere in either case.
  EXPECT_TRUE(until([&] { return there.stats().replies_dropped + there.stats().replies == 1; }));
}

TEST_F(MirrorServices, count_what_is_no_request_and_go_on) {
  there.load(adding, "adder");
  const auto participant = test::make_participant();
  const auto client = raw_client(*participant);
  client->make_reply_reader();
  ASSERT_TRUE(client->matched());
  const unsigned seed = 7;
  std::mt19937 random{seed};
  constexpr unsigned kMessages = 300;
  for (unsigned i = 0; i < kMessages; ++i) {
    Bytes bytes(4 + random() % 29);  // header and body take 36, padding included
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[0] = 0;
    bytes[1] = 1;
    client->say(bytes);
    ASSERT_TRUE(until([&] { return there.stats().broken == i + 1; })) << "seed " << seed << ", message " << i;
  }
  client->say({99, 7}, request_of(1, 1));
  EXPECT_EQ(read_reply(client->next()).second, 2);
  EXPECT_EQ(there.problems.lock()->size(), 1U) << "told once";
  EXPECT_EQ(adding.asked, 1);
}

TEST_F(MirrorServices, count_what_is_no_reply_and_go_on) {
  here.load(calling, "caller");
  const auto participant = test::make_participant();
  const auto server = raw_server(*participant);
  ASSERT_TRUE(server->matched());
  ASSERT_TRUE(until([&] { return calling.client->service_is_ready(); }));
  const auto asked = [&] {
    Bytes scratch;
    const Bytes bytes = server->next();
    const auto call = transport_dds::read_call(bytes, scratch);
    EXPECT_TRUE(call);
    return call ? call->header : transport_dds::CallHeader{};
  };
  auto pending = calling.client->async_send_request(request_of(1, 2));
  const auto first = asked();
  EXPECT_EQ(first.sequence, 1);
  const unsigned seed = 11;
  std::mt19937 random{seed};
  for (int i = 0; i < 300; ++i) {
    Bytes bytes(4 + random() % 60);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[0] = 0;
    bytes[1] = 1;
    server->say(bytes);
  }
  server->say({first.client + 1, first.sequence}, response_of(1));  // another client's
  server->say({first.client, first.sequence + 1}, response_of(2));  // nobody has asked that
  server->say(first, response_of(3));
  server->say(first, response_of(4));  // and once more
  EXPECT_EQ(calling.answer_to(std::move(pending))->sum, 3) << "seed " << seed;
  EXPECT_TRUE(until([&] { return here.stats().late == 2; }));

  // Its header is right and its body is not: nobody else will answer.
  pending = calling.client->async_send_request(request_of(1, 2));
  const auto second = asked();
  const AddTwoInts::Response body = response_of(5);
  Bytes whole(transport_dds::call_size(AddTwoInts::Response::message_type(), &body));
  transport_dds::write_call(second, AddTwoInts::Response::message_type(), &body, whole.data());
  server->say(ByteView(whole).first(whole.size() - 4));
  EXPECT_EQ(calling.answer_to(std::move(pending)), nullptr);
  EXPECT_EQ(here.stats().calls_failed, 1U);
  EXPECT_EQ(second.sequence, 2);
}

TEST_F(MirrorServices, do_not_hear_another_definition_of_their_type) {
  there.load(adding, "adder");
  here.load(calling, "caller");
  ASSERT_TRUE(joined());
  const std::string other_hash = "RIHS01_" + std::string(64, '0');
  const auto participant = test::make_participant();
  const auto client = raw_client(*participant, " 1.10.0.0.0.0.0.0.0.0.0.0.0.0.0.1", other_hash);
  ASSERT_TRUE(client->matched());
  client->say({99, 1}, request_of(1, 1));
  EXPECT_TRUE(until([&] { return there.stats().stray == 1; }));
  EXPECT_THAT(*there.problems.lock(), Contains(HasSubstr(other_hash)));
  EXPECT_EQ(adding.asked, 0);
}

// As rmw_fastrtps announces its ends: the type's hash and no id.
TEST_F(MirrorServices, tell_apart_those_of_another_middleware) {
  there.load(adding, "adder");
  here.load(calling, "caller");
  const auto participant = test::make_participant();
  const std::string request_hash = AddTwoInts::Request::message_type().hash;
  const auto client = raw_client(*participant, "", request_hash);
  ASSERT_TRUE(client->matched());
  Bytes two_words{0, 1, 0, 0};
  two_words.resize(4 + 16);
  client->say(two_words);
  EXPECT_TRUE(until([&] { return there.stats().stray == 1; }));
  EXPECT_THAT(*there.problems.lock(), ElementsAre(HasSubstr("RMW_IMPLEMENTATION=rmw_cyclonedds_cpp")));

  Calling<AddTwoInts> alone{"/elsewhere"};
  MirroredContainer asking{"asking"};
  asking.load(alone, "alone");
  const RawEnd fast{
      *participant, AddTwoInts::Request::message_type(), AddTwoInts::Response::message_type(), "/elsewhere", true, "",
      request_hash};
  ASSERT_TRUE(until([&] { return !asking.problems.lock()->empty(); }));
  EXPECT_FALSE(alone.client->service_is_ready());
}

// --- what ROS 2 was heard to say -------------------------------------------------------------------------------------

/// The first recorded reply of this service with the request that it answers, if that was recorded.
struct Exchange {
  Bytes request, reply;
};
template <typename S>
Exchange recorded_exchange(const std::string& recording, const std::string& service, std::size_t number) {
  using transport_dds::read_call;
  Bytes scratch;
  std::vector<Exchange> all;
  const auto samples = transport_dds::recorded::samples(recording);
  for (const auto& asked : samples) {
    if (asked.topic != "rq" + service + "Request") continue;
    for (const auto& reply : samples) {
      if (reply.topic != "rr" + service + "Reply") continue;
      const auto header = read_call(asked.payload, scratch)->header;
      if (!(read_call(reply.payload, scratch)->header == header)) continue;
      const bool known =
          std::any_of(all.begin(), all.end(), [&](const Exchange& e) { return e.request == asked.payload; });
      if (!known) all.push_back({asked.payload, reply.payload});
    }
  }
  EXPECT_GT(all.size(), number) << service;
  return all.size() > number ? all[number] : Exchange{};
}

template <typename S>
void replay(const std::string& recording, const std::string& service, std::size_t number) {
  const Exchange exchange = recorded_exchange<S>(recording, service, number);
  ASSERT_FALSE(exchange.reply.empty());
  Bytes scratch;
  typename S::Request expected;
  typename S::Response response;
  ASSERT_TRUE(msgs::from_cdr(transport_dds::read_call(exchange.request, scratch)->message, expected));
  ASSERT_TRUE(msgs::from_cdr(transport_dds::read_call(exchange.reply, scratch)->message, response));
  std::atomic<bool> is_as_recorded{false};
  Offering<S> offering{service, [&](const typename S::Request& asked, typename S::Response& answer) {
                         is_as_recorded = asked == expected;
                         answer = response;
                       }};
  MirroredContainer there{"there"};
  there.load(offering, "offering");
  const auto participant = test::make_participant();
  RawEnd client{*participant, S::Request::message_type(),         S::Response::message_type(), service,
                false,        " 1.10.0.0.0.0.0.0.0.0.0.0.0.0.0.1"};
  client.make_reply_reader();
  ASSERT_TRUE(client.matched());
  client.say(exchange.request);
  Bytes written = client.next();
  EXPECT_TRUE(is_as_recorded) << service;
  // Both may be padded to four bytes.
  Bytes reply = exchange.reply;
  reply.resize((reply.size() + 3) / 4 * 4);
  written.resize((written.size() + 3) / 4 * 4);
  EXPECT_EQ(to_hex(written), to_hex(reply)) << service;
}

TEST(MirrorReplay, of_recorded_requests_has_the_recorded_replies) {
  replay<GetState>("lc", "/lc_talker/get_state", 0);
  replay<GetState>("lc", "/lc_talker/get_state", 1);
  replay<lifecycle_msgs::srv::GetAvailableTransitions>("lc", "/lc_talker/get_available_transitions", 0);
  replay<lifecycle_msgs::srv::ChangeState>("lc", "/lc_talker/change_state", 0);
}

}  // namespace
}  // namespace nacelle
