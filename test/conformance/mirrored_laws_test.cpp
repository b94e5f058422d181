// SPDX-License-Identifier: Apache-2.0
// Laws over the network that replace those which hold within one machine only, and the reports on incompatible peers: plain DDS
// endpoints, as any middleware creates them.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <std_msgs/msg/header.hpp>

#include "transport_laws.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::say;
using test::Texts;
using ::testing::AllOf;
using ::testing::HasSubstr;

// --- with a network that comes to rest after each call ---------------------------------------------------------------

using MirroredTransport = TransportLaws<test::MirroredBrokers>;

TEST_F(MirroredTransport, tells_writers_apart_numbers_their_messages_and_knows_when_they_were_sent) {
  auto one = transport.create_writer(spec(10));
  auto two = transport.create_writer(spec(10));
  auto reader = transport.create_reader(spec(10), Taking::Share, nullptr);
  const MonotonicTime began = transport.brokers_clock().now();
  send(*one, "a");
  clock.advance(5ms);
  const MonotonicTime then = transport.brokers_clock().now();
  send(*two, "b");
  send(*one, "c");
  std::vector<MessageInfo> infos;
  while (Block* const block = reader->take()) {
    infos.push_back(block->info);
    drop_reference(*block);
  }
  ASSERT_EQ(infos.size(), 3U);
  EXPECT_NE(infos[0].writer_id, infos[1].writer_id);
  EXPECT_EQ(infos[0].writer_id, infos[2].writer_id);
  EXPECT_EQ(infos[0].sequence, 1U);
  EXPECT_EQ(infos[1].sequence, 1U);
  EXPECT_EQ(infos[2].sequence, 2U);
  EXPECT_EQ(infos[0].source_time, began);
  EXPECT_EQ(infos[1].source_time, then);
  EXPECT_EQ(infos[2].received_time, then);
}

TEST_F(MirroredTransport, numbers_what_a_late_reader_gets_from_one) {
  auto writer = transport.create_writer(spec(QoS(2).transient_local()));
  for (const char* text : {"a", "b", "c"}) send(*writer, text);
  auto late = transport.create_reader(spec(QoS(5).transient_local()), Taking::Share, nullptr);
  for (std::uint64_t sequence : {1U, 2U}) {
    Block* const block = late->take();
    ASSERT_NE(block, nullptr);
    EXPECT_EQ(block->info.sequence, sequence) << "Cyclone does not pass DDS's own sequence number";
    drop_reference(*block);
  }
}

TEST_F(MirroredTransport, what_crosses_is_encoded_once_and_an_adopted_message_goes_home) {
  auto writer = transport.create_writer(spec(10));
  auto one = transport.create_reader(spec(10), Taking::Share, nullptr);
  auto two = transport.create_reader(spec(10), Taking::Own, nullptr);
  const std::uint64_t fences = transport.writers_stats().encoded;
  auto message = std::make_unique<String>();
  message->data = "adopted";
  writer->publish(*writer->adopt(message.release()));
  EXPECT_EQ(receive(*one), Texts{"adopted"});
  EXPECT_EQ(receive(*two), Texts{"adopted"});
  EXPECT_LE(transport.writers_stats().encoded - fences, 3U) << "one, and the fences behind it";
  EXPECT_EQ(transport.copies_at("/chat"), 1U) << "not once for each reader";
}

TEST_F(MirroredTransport, no_publisher_waits_for_a_full_keep_all_reader_that_counts_what_it_refuses) {
  auto reader = transport.create_reader(spec(QoS(KeepAll{}).max_samples(1)), Taking::Share, nullptr);
  // Longer than the test may take, so that a wait would be noticed.
  auto writer = transport.create_writer(spec(QoS(10).max_blocking_time(1h)));
  for (const char* text : {"a", "b", "c"}) EXPECT_EQ(send(*writer, text), PublishResult::Published);
  EXPECT_EQ(receive(*reader), Texts{"a"});
  EXPECT_EQ(reader->counters().full, 2U);
  EXPECT_EQ(reader->status().lost, 2U);
  EXPECT_EQ(writer->counters().would_block, 0U);
  send(*writer, "d");
  EXPECT_EQ(receive(*reader), Texts{"d"}) << "the stream goes on";
}

TEST_F(MirroredTransport, a_late_reader_that_is_best_effort_gets_what_comes_and_no_history) {
  auto writer = transport.create_writer(spec(QoS(5).transient_local()));
  send(*writer, "history");
  auto late = transport.create_reader(spec(QoS(5).transient_local().best_effort()), Taking::Share, nullptr);
  EXPECT_EQ(late->writer_count(), 1U);
  send(*writer, "live");
  EXPECT_EQ(receive(*late), Texts{"live"}) << "Cyclone sends a history to reliable readers only";
}

// --- by the clock of DDS ---------------------------------------------------------------------------------------------

class MirroredInTime : public ::testing::Test {
 public:
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return there.bell.until(holds);
  }
  test::MirroredBroker here{"talker"}, there{"listener"};
};

TEST_F(MirroredInTime, expired_history_is_not_sent_to_a_late_reader) {
  const QoS history = QoS(5).transient_local();
  constexpr Duration kLifespan = 200ms;
  auto forgets = here.writer("/news", QoS(history).lifespan(kLifespan));
  auto keeps = here.writer("/news", history);
  say(*forgets, "old");
  say(*keeps, "kept");
  ASSERT_TRUE(until([&] { return here.stats().encoded == 2; }));
  ASSERT_TRUE(until([&, sent = here.clock.now()] { return here.clock.now() - sent > 2 * kLifespan; }));
  auto late = there.reader("/news", QoS(1000).transient_local());
  std::set<std::string> heard;
  // Each of them may grow old on a slow machine before it is taken.
  EXPECT_TRUE(until([&] {
    say(*forgets, "new");
    for (auto& text : hear(*late)) heard.insert(std::move(text));
    return heard.size() == 2;
  }));
  EXPECT_EQ(heard, (std::set<std::string>{"kept", "new"}));
}

TEST_F(MirroredInTime, manual_liveliness_of_a_remote_writer_is_lost_and_comes_back) {
  constexpr Duration kLease = 200ms;
  const QoS manual = QoS(10).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(kLease);
  auto writer = here.writer("/life", manual);
  auto reader = there.reader("/life", manual);
  const auto is = [&](std::uint32_t alive, std::uint32_t not_alive) {
    const EndpointStatus status = reader->status();
    return status.alive == alive && status.not_alive == not_alive;
  };
  ASSERT_TRUE(until([&] { return writer->reader_count() + reader->writer_count() == 2; }));
  ASSERT_TRUE(until([&] { return is(0, 1); })) << "the writer was silent for a lease";
  // More than once: a slow machine may look when it is over again. Cyclone takes a message for a return, and no assertion.
  const auto returns = [&] { return say(*writer, "here"), is(1, 0); };
  EXPECT_TRUE(until(returns));
  EXPECT_TRUE(until([&] { return is(0, 1); }));
  EXPECT_TRUE(until([&] { return writer->status().liveliness_lost >= 2; })) << "the writer's own side may see it later";
  // Assertions alone keep it alive for three leases on end, on a machine that does not sleep through one.
  MonotonicTime since;
  EXPECT_TRUE(until([&] {
    writer->assert_liveliness();
    if (is(1, 0)) return here.clock.now() - since > 3 * kLease;
    returns();
    since = here.clock.now();
    return false;
  }));
  writer.reset();
  EXPECT_TRUE(until([&] { return is(0, 0); }));
}

TEST_F(MirroredInTime, reports_another_type_once_on_each_side_but_not_for_a_node_that_reads_both) {
  const auto read_header = [&](const std::string& topic, const std::string& node) {
    EndpointSpec spec = there.spec(topic);
    spec.type = &std_msgs::msg::Header::message_type();
    spec.node = node;
    return there.broker.create_reader(spec, Taking::Share, nullptr);
  };
  auto command = here.writer("/command");
  auto first_of_base = read_header("/command", "/base");
  ASSERT_TRUE(until([&] { return there.stats().readers == 1; }));  // and is announced before the other
  EndpointSpec fitting = there.spec("/command");
  fitting.node = "/base";
  auto second_of_base = there.broker.create_reader(fitting, Taking::Share, nullptr);
  ASSERT_TRUE(until([&] { return command->reader_count() == 1; }));

  auto odd = here.writer("/odd");
  auto reader = read_header("/odd", "/listener");
  ASSERT_TRUE(until([&] { return !here.problems.lock()->empty() && !there.problems.lock()->empty(); }));
  // Everything known before it is reported once the next endpoint has been processed.
  auto again = there.reader("/behind");
  auto more = here.writer("/odd");
  ASSERT_TRUE(until([&] { return there.stats().readers == 4 && here.stats().writers == 3; }));
  for (auto* side : {&here, &there}) {
    const Texts told = *side->problems.lock();
    ASSERT_EQ(told.size(), 1U);
    const std::string other = side == &here ? "/listener reads " : "/talker publishes ";
    EXPECT_THAT(told[0],
                AllOf(HasSubstr("/odd: " + other), HasSubstr("std_msgs/msg/Header"), HasSubstr("std_msgs/msg/String")));
  }
  EXPECT_EQ(odd->reader_count() + reader->writer_count(), 0U);
  for (const EndpointStatus& status : {odd->status(), reader->status()}) {
    EXPECT_EQ(status.incompatible_type, 1U);
    EXPECT_EQ(status.last_policy, "type");
    EXPECT_THAT(status.last_clash, AllOf(HasSubstr("/talker"), HasSubstr("/listener")));
  }
  EXPECT_EQ(command->status().incompatible_type + first_of_base->status().incompatible_type, 0U);
}

// --- peers that do not fit -------------------------------------------------------------------------------------------

struct Misfit {
  const char* policy;  // as this side calls it
  transport_dds::DdsPolicy number;
  QoS offered, requested;
};

std::vector<Misfit> every_misfit() {
  using enum transport_dds::DdsPolicy;
  return {{"reliability", Reliability, QoS(1).best_effort(), QoS(1)},
          {"durability", Durability, QoS(1), QoS(1).transient_local()},
          {"deadline", Deadline, QoS(1).deadline(2s), QoS(1).deadline(1s)},
          {"liveliness", Liveliness, QoS(1), QoS(1).liveliness(nacelle::Liveliness::ManualByTopic)},
          {"liveliness_lease_duration", Liveliness, QoS(1), QoS(1).liveliness_lease_duration(30s)}};
}

class MirrorBesidePeer : public ::testing::Test {
 public:
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here.bell.until(holds);
  }
  static void expect_told(const EndpointStatus& status, const Misfit& misfit) {
    EXPECT_EQ(status.incompatible_qos, 1U) << misfit.policy;
    EXPECT_EQ(status.last_policy, misfit.policy);
    EXPECT_EQ(status.matched_total, 0U) << misfit.policy;
    EXPECT_THAT(status.last_clash, AllOf(HasSubstr(misfit.policy), HasSubstr("/node"), HasSubstr("participant")));
  }
  [[nodiscard]] Texts problems() { return *here.problems.lock(); }

  test::MirroredBroker here{"node"};
  test::Told told;
  const std::unique_ptr<transport_dds::Participant> peer = test::make_participant();
};

TEST_F(MirrorBesidePeer, reports_an_incompatible_reader_of_a_peer_on_both_sides_with_the_policy) {
  std::vector<std::unique_ptr<Writer>> writers;
  std::vector<std::unique_ptr<transport_dds::Reader>> readers;
  for (const Misfit& misfit : every_misfit()) {
    writers.push_back(here.writer(std::string("/") + misfit.policy, misfit.offered));
    auto reader = peer->create_reader(test::string_topic(misfit.policy, misfit.requested), &told);
    ASSERT_TRUE(reader);
    readers.push_back(std::move(*reader));
  }
  for (std::size_t i = 0; i < writers.size(); ++i) {
    const Misfit misfit = every_misfit()[i];
    EXPECT_TRUE(until([&] { return writers[i]->status().incompatible_qos != 0; })) << misfit.policy;
    expect_told(writers[i]->status(), misfit);
    // Not how often: Cyclone counts a misfit twice that both ends find at once.
    EXPECT_TRUE(told.until([&] { return readers[i]->status().incompatible_qos != 0; })) << misfit.policy;
    EXPECT_EQ(readers[i]->status().last_policy, misfit.number);
  }
}

TEST_F(MirrorBesidePeer, reports_an_incompatible_writer_of_a_peer_on_both_sides_with_the_policy) {
  std::vector<std::unique_ptr<Reader>> readers;
  std::vector<std::unique_ptr<transport_dds::Writer>> writers;
  for (const Misfit& misfit : every_misfit()) {
    readers.push_back(here.reader(std::string("/") + misfit.policy, misfit.requested));
    auto writer = peer->create_writer(test::string_topic(misfit.policy, misfit.offered), &told);
    ASSERT_TRUE(writer);
    writers.push_back(std::move(*writer));
  }
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const Misfit misfit = every_misfit()[i];
    EXPECT_TRUE(until([&] { return readers[i]->status().incompatible_qos != 0; })) << misfit.policy;
    expect_told(readers[i]->status(), misfit);
    // Not how often: Cyclone counts a misfit twice that both ends find at once.
    EXPECT_TRUE(told.until([&] { return writers[i]->status().incompatible_qos != 0; })) << misfit.policy;
    EXPECT_EQ(writers[i]->status().last_policy, misfit.number);
  }
}

transport_dds::EndpointOptions with_hash(transport_dds::EndpointOptions options, const std::string& hash) {
  const std::string data = "typehash=" + hash + ";";
  const ByteView bytes = as_bytes(data);
  options.user_data.assign(bytes.begin(), bytes.end());
  return options;
}

// Found in DDS's builtin topics: neither name nor hash of a type makes a DDS status.
TEST_F(MirrorBesidePeer, reports_a_mismatched_type_once_with_both_types) {
  const std::string hash = "RIHS01_" + std::string(64, '0');
  auto writer = here.writer("/hash");
  auto reader = here.reader("/name");
  std::vector<std::unique_ptr<transport_dds::Reader>> others;
  for (int i = 0; i < 2; ++i) {
    auto made = peer->create_reader(with_hash(test::string_topic("hash"), hash), &told);
    ASSERT_TRUE(made);
    others.push_back(std::move(*made));
  }
  auto named = test::string_topic("name");
  named.type = "std_msgs::msg::dds_::Header_";
  auto other = peer->create_writer(named, &told);
  ASSERT_TRUE(other);
  // Both readers are one problem, and the second one may become known later than the writer.
  ASSERT_TRUE(until([&] { return problems().size() >= 2 && writer->status().incompatible_type >= 2; }));
  // What comes and fits is known by now, and so is all that did not.
  auto fits = peer->create_writer(test::string_topic("name"), &told);
  ASSERT_TRUE(fits);
  ASSERT_TRUE(until([&] { return reader->writer_count() == 1; }));
  auto again = here.writer("/hash");
  ASSERT_TRUE(until([&] { return here.stats().writers == 2; }));
  Texts all = problems();
  ASSERT_EQ(all.size(), 2U);
  std::ranges::sort(all);
  EXPECT_THAT(all[0], AllOf(HasSubstr("/hash"), HasSubstr(hash), HasSubstr(String::message_type().hash)));
  EXPECT_THAT(all[1], AllOf(HasSubstr("/name"), HasSubstr("std_msgs/msg/Header"), HasSubstr("std_msgs/msg/String")));
  EXPECT_EQ(writer->reader_count(), 0U);
  EXPECT_EQ(writer->status().matched_total, 0U);
  EXPECT_EQ(writer->status().incompatible_type, 2U) << "both readers";
  EXPECT_THAT(writer->status().last_clash, HasSubstr(hash));
  EXPECT_EQ(reader->status().incompatible_type, 1U);
  EXPECT_EQ(reader->status().last_policy, "type");
}

}  // namespace
}  // namespace nacelle
