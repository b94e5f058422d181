// SPDX-License-Identifier: Apache-2.0
// The mirror queries a peer whose clock may be behind. The peer is handmade, so that a test sets its stamps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <rcl_interfaces/srv/get_parameter_types.hpp>

#include "mirrored_container.hpp"
#include "support/manual_clock.hpp"

namespace nacelle {
namespace {

using rcl_interfaces::srv::GetParameterTypes;
using test::RawEnd;
using transport_dds::CallHeader;

constexpr const char* kAsked = "/laptop/get_parameter_types";
constexpr const char* kId = " 1.10.0.0.0.0.0.0.0.0.0.0.0.0.0.1";

/// No server and no client on this side.
struct NoServices final : ServiceGraph {
  void join(ServiceListener&) override {}
  void leave(ServiceListener&) override {}
  void set_remote(std::uint64_t, RemoteServer*) override {}
  [[nodiscard]] Sent send(std::uint64_t, Call) override { return Sent::Gone; }
};

struct Laptop {
  Laptop() : server(*participant, request, response, kAsked, true, kId) {}
  struct Question {
    CallHeader header;
    WallTime sent;
  };
  [[nodiscard]] Question next_question() {
    std::optional<transport_dds::Sample> sample;
    if (!server.told.until([&] { return (sample = server.reader->take()).has_value(); })) return {};
    Bytes scratch;
    const auto call = transport_dds::read_call(sample->payload.bytes(), scratch);
    return call ? Question{call->header, sample->source_time} : Question{};
  }
  void answer(const CallHeader& header, WallTime stamp) {
    const GetParameterTypes::Response message;
    auto payload = server.writer->borrow(transport_dds::call_size(response, &message));
    transport_dds::write_call(header, response, &message, payload.bytes().data());
    EXPECT_EQ(server.writer->write(std::move(payload), stamp), transport_dds::Writer::Sent::Yes);
  }

  const msgs::MessageType& request = GetParameterTypes::Request::message_type();
  const msgs::MessageType& response = GetParameterTypes::Response::message_type();
  const std::unique_ptr<transport_dds::Participant> participant = test::make_participant();
  RawEnd server;
};

class ClockQuestions : public ::testing::Test {
 public:
  void start(std::vector<transport_dds::ExportRule> exports = {}) {
    static std::uint32_t next = 3000000;  // in this process; on the network they share test_domain()
    MirrorOptions options;
    options.domain_id = next++;
    options.config = test::loopback_config(test::test_domain());
    options.exports = std::move(exports);
    auto made = DdsMirror::start(broker, network, std::move(options), &nobody);
    ASSERT_TRUE(made) << made.error().text();
    mirror = std::move(*made);
    EndpointSpec spec{"/chatter", &test::String::message_type(), QoS(10), "/here"};
    reader = broker.create_reader(spec, Taking::Share, &bell);
    talker = laptop.participant->create_writer(test::string_topic("chatter"), &told).value();
    ASSERT_TRUE(told.until([&] { return talker->matched_count() == 1; }));
    ASSERT_TRUE(bell.until([&] {
      bool knows = false;
      mirror->look([&](const transport_dds::RemoteGraph& graph) {
        knows = graph.ends_of_service(kAsked).size() == 2 && graph.ends_of_topic("/chatter").size() == 1;
      });
      return knows && mirror->stats().stand_ins == 1;
    }));
  }
  /// Messages that are so old when they come, twice a second.
  void hear_for(Duration time, Duration age) {
    for (Duration passed{}; passed < time; passed += 500ms) {
      network.advance(500ms);
      EXPECT_EQ(test::say(*talker, "x", network.wall_now() - age), transport_dds::Writer::Sent::Yes);
      const auto said = ++heard;
      ASSERT_TRUE(bell.until([&] { return mirror->stats().decoded == said; }));
    }
  }
  [[nodiscard]] bool is_met() {
    return laptop.server.told.until(
        [&] { return laptop.server.reader->matched_count() == 1 && laptop.server.writer->matched_count() == 1; });
  }
  [[nodiscard]] bool is_left() {
    return laptop.server.told.until(
        [&] { return laptop.server.reader->matched_count() == 0 && laptop.server.writer->matched_count() == 0; });
  }
  /// Advances time until `holds`: the network's thread checks periodically which peers it has matched.
  template <typename F>
  [[nodiscard]] bool hear_until(F holds, Duration age) {
    return bell.until([&] {
      if (!holds()) hear_for(500ms, age);
      return HasFatalFailure() || holds();
    });
  }
  /// Advances time until there is one. Time may have passed since it was sent, so an answer's stamp counts from `sent`.
  [[nodiscard]] Laptop::Question next_question(Duration age) {
    ++questions;
    EXPECT_TRUE(hear_until([&] { return mirror->stats().clock_questions >= questions; }, age));
    return laptop.next_question();
  }
  [[nodiscard]] bool is_answered(std::uint64_t times) {
    return bell.until([&] { return mirror->stats().clock_answers == times; });
  }

  test::ManualClock network;
  SystemClock clock;
  test::Bell bell;
  test::Told told;
  NoServices nobody;
  runtime::Broker broker{clock, runtime::Watching::ByThread};
  std::unique_ptr<Reader> reader;
  std::unique_ptr<DdsMirror> mirror;
  Laptop laptop;
  std::unique_ptr<transport_dds::Writer> talker;
  std::uint64_t heard = 0, questions = 0;
};

TEST_F(ClockQuestions, are_not_sent_to_a_machine_whose_clock_agrees) {
  start();
  hear_for(60s, 2ms);
  EXPECT_EQ(mirror->stats().clock_questions, 0U);
  EXPECT_EQ(laptop.server.reader->status().matched_total, 0U) << "not even an end was there for it";
}

TEST_F(ClockQuestions, show_that_a_clock_is_behind_and_end) {
  start();
  hear_for(5s, 40ms);
  ASSERT_TRUE(is_met());
  for (std::uint64_t i = 0; i < 3; ++i) {
    const auto [header, sent] = next_question(40ms);
    if (i == 0) {
      Laptop namesake;  // whose stamps are not the laptop's
      ASSERT_TRUE(namesake.server.matched());
      namesake.answer(header, sent - 10s);
    }
    laptop.answer({header.client + 1, header.sequence}, sent - 20s);
    laptop.answer({header.client, header.sequence + 100}, sent - 20s);
    laptop.answer(header, sent - 40ms);
    ASSERT_TRUE(is_answered(i + 1));
  }
  ASSERT_TRUE(is_left());
  hear_for(2s, 40ms);
  const auto skews = mirror->clock_skews();
  ASSERT_EQ(skews.size(), 1U);
  EXPECT_TRUE(skews[0].is_certain());
  EXPECT_LE(skews[0].ahead(), -39ms);
  EXPECT_GE(skews[0].ahead(), -40ms);
  EXPECT_EQ(mirror->stats().clock_answers, 3U);
  const auto asked = mirror->stats().clock_questions;
  EXPECT_EQ(asked, questions);
  hear_for(20s, 40ms);
  EXPECT_EQ(mirror->stats().clock_questions, asked) << "not again for a while";
  EXPECT_NE(next_question(40ms).header.client, 0U);
}

TEST_F(ClockQuestions, find_that_the_way_is_slow) {
  start();
  hear_for(5s, 150ms);
  ASSERT_TRUE(is_met());
  const auto [header, sent] = next_question(150ms);
  laptop.answer(header, sent);
  ASSERT_TRUE(is_answered(1));
  hear_for(20s, 150ms);
  EXPECT_TRUE(mirror->clock_skews().empty());
}

TEST_F(ClockQuestions, leave_it_to_the_ages_if_there_is_no_answer) {
  start();
  hear_for(5s, 150ms);
  ASSERT_TRUE(is_met());
  EXPECT_TRUE(mirror->clock_skews().empty()) << "reported before the answer could arrive";
  ASSERT_TRUE(hear_until([&] { return !mirror->clock_skews().empty(); }, 150ms));
  ASSERT_TRUE(is_left());
  EXPECT_LE(mirror->stats().clock_questions, 5U);
  const auto skews = mirror->clock_skews();
  ASSERT_EQ(skews.size(), 1U);
  EXPECT_FALSE(skews[0].is_certain());
  EXPECT_EQ(skews[0].ahead(), -150ms);
}

TEST_F(ClockQuestions, are_not_asked_where_the_list_of_exports_does_not_name_them) {
  start({{.topic = "/chatter"}});
  hear_for(30s, 150ms);
  EXPECT_EQ(mirror->stats().clock_questions, 0U);
  EXPECT_EQ(laptop.server.reader->status().matched_total, 0U);
  EXPECT_EQ(mirror->clock_skews().size(), 1U);
}

}  // namespace
}  // namespace nacelle
