// SPDX-License-Identifier: Apache-2.0
// Services and clients of a container beside malformed messages of peers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "mirrored_services.hpp"
#include "support/manual_clock.hpp"

namespace nacelle {
namespace {

using test::add;
using test::AddTwoInts;
using test::Calling;
using test::MirroredContainer;
using test::MirrorServices;
using test::Offering;
using test::raw_client;
using test::raw_server;
using test::RawEnd;
using test::read_reply;
using test::request_of;
using test::response_of;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

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
  MirroredContainer there{"there", {}, &network};
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
  // Cyclone reports the end to the reader and to discovery separately. Without a reader the reply reaches no client in either case.
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
  EXPECT_EQ(there.problems.lock()->size(), 1U) << "reported once";
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
  server->say({first.client, first.sequence + 1}, response_of(2));  // without such a request
  server->say(first, response_of(3));
  server->say(first, response_of(4));  // and once more
  EXPECT_EQ(calling.answer_to(std::move(pending))->sum, 3) << "seed " << seed;
  EXPECT_TRUE(until([&] { return here.stats().late == 2; }));

  // Its header is valid and its body is not: no other answer will come.
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

TEST_F(MirrorServices, ignore_another_definition_of_their_type) {
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
TEST_F(MirrorServices, detect_another_middleware) {
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

}  // namespace
}  // namespace nacelle
