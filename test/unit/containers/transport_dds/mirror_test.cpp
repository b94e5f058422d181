// SPDX-License-Identifier: Apache-2.0
// Two graphs in one process that only the network joins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <random>
#include <sensor_msgs/msg/image.hpp>
#include <std_msgs/msg/header.hpp>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::say;
using test::Texts;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Mirror : public ::testing::Test {
 public:
  /// Either side's bell may ring for what the test waits for; figures of both are looked at.
  template <typename F>
  [[nodiscard]] bool until(F holds) {
    return here.bell.until(holds);
  }
  /// The writer's messages reach the reader from now on.
  [[nodiscard]] bool joined(const Writer& writer, const Reader& reader) {
    return until([&] { return writer.reader_count() == 1 && reader.writer_count() == 1; });
  }

  test::MirroredBroker here{"talker"}, there{"listener"};
};

TEST_F(Mirror, brings_messages_both_ways) {
  auto there_reads = there.reader("/there");
  auto here_reads = here.reader("/here");
  auto here_writes = here.writer("/there");
  auto there_writes = there.writer("/here");
  ASSERT_TRUE(joined(*here_writes, *there_reads));
  ASSERT_TRUE(joined(*there_writes, *here_reads));
  for (const char* text : {"one", "two", ""}) say(*here_writes, text);
  say(*there_writes, "answer");
  EXPECT_EQ(hear(there.bell, *there_reads, 3), (Texts{"one", "two", ""}));
  EXPECT_EQ(hear(here.bell, *here_reads, 1), Texts{"answer"});
  EXPECT_EQ(here.stats().problems + there.stats().problems, 0U);
}

TEST_F(Mirror, tells_who_wrote_a_message_when_and_which_it_was) {
  auto reader = there.reader("/info");
  auto writer = here.writer("/info");
  ASSERT_TRUE(joined(*writer, *reader));
  const MonotonicTime before = here.clock.now();
  for (int i = 1; i <= 2; ++i) say(*writer, "x");
  for (std::uint64_t i = 1; i <= 2; ++i) {
    ASSERT_TRUE(there.bell.until([&] { return reader->has_waiting(); }));
    Block* const block = reader->take();
    EXPECT_NE(block->info.writer_id, 0U);
    EXPECT_EQ(block->info.sequence, i);
    // By way of two readings of the wall clock.
    EXPECT_GT(block->info.source_time, before - 100ms);
    EXPECT_LE(block->info.source_time, block->info.received_time);
    drop_reference(*block);
  }
}

TEST_F(Mirror, gives_a_late_reader_what_a_transient_local_writer_has_kept) {
  const QoS latched = QoS(2).transient_local();
  auto writer = here.writer("/latched", latched);
  std::uint64_t said = 0;
  for (const char* text : {"one", "two", "three"}) {
    say(*writer, text);
    ++said;
    ASSERT_TRUE(until([&] { return here.stats().encoded == said; }));
  }
  auto late = there.reader("/latched", latched);
  EXPECT_EQ(hear(there.bell, *late, 2), (Texts{"two", "three"}));
  say(*writer, "four");
  EXPECT_EQ(hear(there.bell, *late, 1), Texts{"four"});
  auto later = there.reader("/latched", latched);
  EXPECT_EQ(hear(there.bell, *later, 2), (Texts{"three", "four"}));
  EXPECT_EQ(hear(*late), Texts{}) << "what is kept for one is not said again to the other";
}

TEST_F(Mirror, sends_what_was_published_before_the_network_was_there) {
  auto writer = here.writer("/early", QoS(1).transient_local());
  here.mirror.reset();
  say(*writer, "early");
  test::MirroredBroker other{"other"};
  auto reader = other.reader("/early", QoS(1).transient_local());
  MirrorOptions options;
  options.domain_id = 900;
  options.config = test::loopback_config(test::test_domain());
  auto again = DdsMirror::start(here.broker, here.clock, options);
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_EQ(hear(other.bell, *reader, 1), Texts{"early"});
}

TEST_F(Mirror, keeps_what_a_closed_gate_has_missed_of_a_history) {
  const QoS latched = QoS(1).transient_local();
  auto reader = there.reader("/map", latched);
  reader->set_enabled(false);
  auto witness = there.reader("/map", latched);
  auto writer = here.writer("/map", latched);
  say(*writer, "map");
  ASSERT_EQ(hear(there.bell, *witness, 1), Texts{"map"});
  EXPECT_EQ(hear(*reader), Texts{});
  reader->set_enabled(true);
  EXPECT_EQ(hear(there.bell, *reader, 1), Texts{"map"});
}

TEST_F(Mirror, drops_what_comes_behind_the_closed_gate_of_a_volatile_reader) {
  auto reader = there.reader("/scan");
  auto witness = there.reader("/scan");
  auto writer = here.writer("/scan");
  ASSERT_TRUE(until([&] { return writer->reader_count() == 2 && reader->writer_count() == 1; }));
  reader->set_enabled(false);
  say(*writer, "unheard");
  ASSERT_EQ(hear(there.bell, *witness, 1), Texts{"unheard"});
  ASSERT_TRUE(until([&] { return reader->counters().inactive == 1; }));
  reader->set_enabled(true);
  say(*writer, "heard");
  EXPECT_EQ(hear(there.bell, *reader, 1), Texts{"heard"});
}

TEST_F(Mirror, names_a_node_that_another_participant_has_too_once_with_its_program) {
  test::MirroredBroker twin{"talker"};
  auto ours = here.writer("/ours");
  auto not_ours = there.writer("/not_ours");
  auto theirs = twin.writer("/theirs");
  ASSERT_TRUE(until([&] { return here.mirror->namesakes().size() == 1 && twin.mirror->namesakes().size() == 1; }));
  const Namesake found = here.mirror->namesakes().front();
  EXPECT_EQ(found.node, "/talker");
  EXPECT_EQ(found.pid, std::to_string(::getpid()));
  EXPECT_NE(found.host, "");
  ASSERT_TRUE(until([&] { return here.problems.lock()->size() == 1; }));
  EXPECT_THAT(here.problems.lock()->front(),
              ::testing::AllOf(::testing::StartsWith("/talker: two nodes of this name"), HasSubstr("ROS_DOMAIN_ID")));
  auto more = twin.writer("/more");
  theirs.reset();
  more.reset();
  EXPECT_TRUE(until([&] { return here.mirror->namesakes().empty(); })) << "its node has gone with its last end";
  EXPECT_EQ(here.problems.lock()->size(), 1U);
  EXPECT_TRUE(there.mirror->namesakes().empty());
  EXPECT_TRUE(there.problems.lock()->empty());
}

TEST_F(Mirror, neither_fetches_nor_encodes_for_nobody) {
  auto writer = here.writer("/lonely");
  auto local = here.reader("/lonely", QoS(200));
  for (int i = 0; i < 100; ++i) say(*writer, "x");
  EXPECT_EQ(hear(here.bell, *local, 100).size(), 100U);
  EXPECT_EQ(here.stats().taps, 0U);

  auto remote = there.reader("/lonely");
  ASSERT_TRUE(until([&] { return writer->reader_count() == 2; }));
  EXPECT_EQ(here.stats().taps, 1U);
  say(*writer, "for both");
  EXPECT_EQ(hear(there.bell, *remote, 1), Texts{"for both"});
  EXPECT_TRUE(until([&] { return here.stats().encoded != 0; })) << "counted when it is gone";
  EXPECT_EQ(here.stats().encoded, 1U) << "one, and nothing of what was before";

  remote.reset();
  ASSERT_TRUE(until([&] { return here.stats().taps == 0; }));
  ASSERT_TRUE(until([&] { return writer->reader_count() == 1; }));
  for (int i = 0; i < 100; ++i) say(*writer, "x");
  EXPECT_EQ(hear(here.bell, *local, 101).size(), 101U);
  EXPECT_EQ(here.stats().encoded, 1U);
}

TEST_F(Mirror, encodes_and_decodes_once_for_several_readers) {
  auto one = there.reader("/shared", QoS(100));
  auto two = there.reader("/shared", QoS(100));
  auto owner = there.reader("/shared", QoS(100), Taking::Own);
  auto writer = here.writer("/shared", QoS(100));
  ASSERT_TRUE(until([&] {
    return writer->reader_count() == 3 && one->writer_count() == 1 && two->writer_count() == 1 &&
           owner->writer_count() == 1;
  }));
  // Until each reader has caught up with the writer, Cyclone brings it bytes of its own. After that they may be served in
  // two turns of the network's thread, but not each time.
  std::uint64_t rounds = 0;
  EXPECT_TRUE(until([&] {
    ++rounds;
    const std::uint64_t before = there.stats().decoded;
    Texts texts;
    for (int i = 0; i < 50; ++i) {
      texts.push_back(std::to_string(i));
      say(*writer, texts.back());
    }
    for (auto* const reader : {one.get(), two.get(), owner.get()}) EXPECT_EQ(hear(there.bell, *reader, 50), texts);
    return there.stats().decoded - before < 100;
  }));
  EXPECT_EQ(here.stats().encoded, 50 * rounds);
}

TEST_F(Mirror, keeps_the_order_of_a_keep_all_stream) {
  const QoS all{KeepAll{}};
  auto reader = there.reader("/numbers", all);
  auto writer = here.writer("/numbers", all);
  ASSERT_TRUE(joined(*writer, *reader));
  Texts sent, got;
  for (int i = 0; i < 500; ++i) {
    sent.push_back(std::to_string(i));
    say(*writer, sent.back());
  }
  EXPECT_EQ(hear(there.bell, *reader, sent.size()), sent);
  EXPECT_EQ(here.stats().overtaken + here.stats().refused, 0U);
}

TEST_F(Mirror, counts_readers_and_writers_of_other_participants) {
  auto writer = here.writer("/counted");
  {
    auto one = there.reader("/counted");
    auto two = there.reader("/counted", QoS(1).best_effort());
    ASSERT_TRUE(until([&] { return writer->reader_count() == 2 && one->writer_count() == 1; }));
    EXPECT_EQ(writer->status().matched, 2U);
    EXPECT_EQ(one->status().matched_total, 1U);
  }
  EXPECT_TRUE(until([&] { return writer->reader_count() == 0; }));
  EXPECT_EQ(writer->status().matched_total, 2U);
  auto three = there.reader("/counted");
  ASSERT_TRUE(until([&] { return three->writer_count() == 1; }));
  writer.reset();
  EXPECT_TRUE(until([&] { return three->writer_count() == 0; }));
}

TEST_F(Mirror, its_end_takes_its_ends_from_the_network) {
  auto writer = here.writer("/ended");
  auto reader = there.reader("/ended");
  ASSERT_TRUE(joined(*writer, *reader));
  there.mirror.reset();
  EXPECT_EQ(reader->writer_count(), 0U);
  EXPECT_TRUE(until([&] { return writer->reader_count() == 0; }));
}

struct Misfit {
  const char* policy;
  QoS offered, requested;
};
void PrintTo(const Misfit& misfit, std::ostream* out) { *out << misfit.policy; }

class MirrorMisfit : public Mirror, public ::testing::WithParamInterface<Misfit> {};

TEST_P(MirrorMisfit, of_qos_is_told_on_both_sides_with_the_policy) {
  auto writer = here.writer("/misfit", GetParam().offered);
  auto reader = there.reader("/misfit", GetParam().requested);
  ASSERT_TRUE(until([&] { return writer->status().incompatible_qos == 1 && reader->status().incompatible_qos == 1; }));
  EXPECT_EQ(writer->status().last_policy, GetParam().policy);
  EXPECT_EQ(reader->status().last_policy, GetParam().policy);
  for (const std::string& text : {writer->status().last_clash, reader->status().last_clash})
    EXPECT_THAT(text, AllOf(HasSubstr("/misfit"), HasSubstr("/talker"), HasSubstr("/listener")));
  EXPECT_EQ(writer->reader_count() + reader->writer_count(), 0U);
}

INSTANTIATE_TEST_SUITE_P(EveryPolicy, MirrorMisfit,
                         ::testing::Values(Misfit{"reliability", QoS(1).best_effort(), QoS(1)},
                                           Misfit{"durability", QoS(1), QoS(1).transient_local()},
                                           Misfit{"deadline", QoS(1), QoS(1).deadline(100ms)},
                                           Misfit{"liveliness", QoS(1), QoS(1).liveliness(Liveliness::ManualByTopic)},
                                           Misfit{"liveliness_lease_duration", QoS(1),
                                                  QoS(1).liveliness_lease_duration(1s)}),
                         [](const auto& one) { return one.param.policy; });

TEST_F(Mirror, tells_once_of_two_types_under_one_name) {
  EndpointSpec other = here.spec("/typed");
  other.type = &std_msgs::msg::Header::message_type();
  auto writer = here.broker.create_writer(other);
  auto reader = there.reader("/typed");
  ASSERT_TRUE(there.bell.until([&] { return !there.problems.lock()->empty(); }));
  ASSERT_TRUE(here.bell.until([&] { return !here.problems.lock()->empty(); }));
  auto again = there.reader("/typed");
  auto fits = here.writer("/typed");
  ASSERT_TRUE(until([&] { return fits->reader_count() == 2 && again->writer_count() == 1; }));
  const Texts told = *there.problems.lock();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_THAT(told[0], HasSubstr("/typed"));
  EXPECT_THAT(told[0], HasSubstr("std_msgs/msg/Header"));
  EXPECT_THAT(told[0], HasSubstr("std_msgs/msg/String"));
  EXPECT_EQ(writer->reader_count(), 0U);
}

TEST_F(Mirror, shows_its_nodes_with_their_ends_as_ros_does) {
  auto writer = here.writer("/chatter");
  auto reader = here.reader("/commands");
  std::optional<transport_dds::RemoteNodeInfo> node;
  ASSERT_TRUE(until([&] {
    there.mirror->look([&](const transport_dds::RemoteGraph& graph) { node = graph.node("/", "talker"); });
    return node && node->publishers.contains("/chatter") && node->subscriptions.contains("/commands");
  }));
  EXPECT_THAT(node->publishers.at("/chatter"), ElementsAre("std_msgs/msg/String"));
  there.mirror->look([&](const transport_dds::RemoteGraph& graph) {
    const auto ends = graph.ends_of_topic("/chatter");
    ASSERT_EQ(ends.size(), 1U);
    EXPECT_EQ(ends[0].user_data.type_hash, test::String::message_type().hash);
    EXPECT_EQ(ends[0].qos.depth(), 10U);
  });
  writer.reset();
  reader.reset();
  EXPECT_TRUE(until([&] {
    bool gone = false;
    there.mirror->look([&](const transport_dds::RemoteGraph& graph) { gone = graph.nodes().empty(); });
    return gone;
  })) << "a node without ends";
}

TEST_F(Mirror, makes_one_snapshot_of_many_changes) {
  const auto before = here.stats().snapshots;
  std::vector<std::unique_ptr<Writer>> many;
  for (int i = 0; i < 100; ++i) many.push_back(here.writer("/many_" + std::to_string(i)));
  ASSERT_TRUE(until([&] { return here.stats().writers == 100; }));
  EXPECT_LT(here.stats().snapshots - before, 100U);
}

TEST_F(Mirror, brings_an_image_of_eight_megabytes_whole) {
  using sensor_msgs::msg::Image;
  EndpointSpec image = there.spec("/image", QoS(2));
  image.type = &Image::message_type();
  auto reader = there.broker.create_reader(image, Taking::Share, &there.bell);
  image = here.spec("/image", QoS(2));
  image.type = &Image::message_type();
  auto writer = here.broker.create_writer(image);
  ASSERT_TRUE(joined(*writer, *reader));
  const auto hear_one = [&](const Image& image) {
    Block* const block = writer->borrow();
    *static_cast<Image*>(block->message) = image;
    writer->publish(*block);
    ASSERT_TRUE(there.bell.until([&] { return reader->has_waiting(); }));
    Block* const got = reader->take();
    EXPECT_TRUE(*static_cast<const Image*>(got->message) == image);
    drop_reference(*got);
  };
  Image sent;
  hear_one(sent);  // see sends_the_large_messages_of_a_writer_that_has_ended
  sent.header.frame_id = "camera";
  sent.data.resize(8U << 20U);
  std::mt19937 random{3};
  for (auto& byte : sent.data) byte = static_cast<std::uint8_t>(random());
  hear_one(sent);
}

TEST_F(Mirror, keeps_the_order_of_large_and_small_messages_of_a_writer) {
  const QoS all{KeepAll{}};
  auto reader = there.reader("/mixed", all);
  auto writer = here.writer("/mixed", all);
  ASSERT_TRUE(joined(*writer, *reader));
  Texts sent;
  for (int i = 0; i < 60; ++i) {
    sent.push_back(std::to_string(i) + std::string(i % 3 == 0 ? 50'000 : 5, 'x'));
    say(*writer, sent.back());
  }
  EXPECT_EQ(hear(there.bell, *reader, sent.size()), sent);
  EXPECT_EQ(here.stats().overtaken + here.stats().refused, 0U);
}

TEST_F(Mirror, sends_the_large_messages_of_a_writer_that_has_ended) {
  auto reader = there.reader("/ending", QoS(5));
  auto writer = here.writer("/ending", QoS(5));
  ASSERT_TRUE(joined(*writer, *reader));
  // What the first heartbeat covers Cyclone takes for history, if it is not whole by then: a volatile reader never gets it.
  say(*writer, "first");
  ASSERT_EQ(hear(there.bell, *reader, 1), Texts{"first"});
  Texts sent;
  for (char c : {'a', 'b', 'c', 'd'}) {
    sent.emplace_back(200'000, c);
    say(*writer, sent.back());
  }
  writer.reset();
  EXPECT_EQ(hear(there.bell, *reader, sent.size()), sent);
  EXPECT_TRUE(until([&] { return reader->writer_count() == 0 && here.stats().writers + here.stats().taps == 0; }));
}

// Context switches of the threads of that name that nobody forced.
std::uint64_t sleeps_of_threads(const std::string& name) {
  std::uint64_t count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream comm(task.path() / "comm"), status(task.path() / "status");
    std::string line;
    if (!std::getline(comm, line) || !line.starts_with(name)) continue;
    const std::string key = "voluntary_ctxt_switches:";
    while (std::getline(status, line)) {
      if (line.starts_with(key)) count += std::stoull(line.substr(key.size()));
    }
  }
  return count;
}

TEST_F(Mirror, sleeps_while_nobody_on_the_network_listens) {
  there.mirror.reset();
  auto writer = here.writer("/lonely");
  auto local = here.reader("/lonely");
  const auto rests = [&, last = std::uint64_t{0}]() mutable {
    const std::uint64_t now = sleeps_of_threads("network");
    return std::exchange(last, now) == now && here.stats().snapshots != 0;
  };
  ASSERT_TRUE(until([&] { return here.stats().writers + here.stats().readers == 2; }));
  ASSERT_TRUE(until(rests));
  // A wake-up by something that is not the messages would be one, not one for each.
  const std::uint64_t before = sleeps_of_threads("network");
  for (int i = 0; i < 1000; ++i) say(*writer, "x");
  EXPECT_LT(sleeps_of_threads("network") - before, 10U);
  EXPECT_EQ(here.stats().encoded + here.stats().taps, 0U);
}

TEST_F(Mirror, counts_bytes_that_are_no_message_and_goes_on) {
  const QoS all{KeepAll{}};
  auto reader = there.reader("/hostile", all);
  test::Told told;
  const auto participant = test::make_participant();
  auto raw = participant->create_writer(test::string_topic("hostile", all), &told);
  ASSERT_TRUE(raw);
  ASSERT_TRUE(until([&] { return reader->writer_count() == 1 && (*raw)->matched_count() == 1; }));
  const unsigned seed = 5;
  std::mt19937 random{seed};
  constexpr unsigned kMessages = 300;
  for (unsigned i = 0; i < kMessages; ++i) {
    Bytes bytes(4 + random() % 200);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[0] = 0;
    bytes[1] = 1;
    if (bytes.size() > 7) bytes[7] |= 0x80;  // a length that no text of these bytes has
    ASSERT_EQ(test::say_bytes(**raw, bytes), transport_dds::Writer::Sent::Yes);
  }
  ASSERT_EQ(test::say(**raw, "sane"), transport_dds::Writer::Sent::Yes);
  EXPECT_EQ(hear(there.bell, *reader, 1), Texts{"sane"});
  EXPECT_EQ(there.stats().broken, kMessages) << "seed " << seed;
  EXPECT_EQ(there.problems.lock()->size(), 1U) << "told once";
}

TEST_F(Mirror, does_not_listen_to_another_definition_of_a_type) {
  auto reader = there.reader("/defined");
  test::Told told;
  const auto participant = test::make_participant();
  auto options = test::string_topic("defined");
  const std::string data = "typehash=RIHS01_" + std::string(64, '0') + ";";
  const ByteView bytes = as_bytes(data);
  options.user_data.assign(bytes.begin(), bytes.end());
  auto raw = participant->create_writer(options, &told);
  ASSERT_TRUE(raw);
  ASSERT_TRUE(told.until([&] { return (*raw)->matched_count() == 1; }));
  ASSERT_TRUE(there.bell.until([&] { return !there.problems.lock()->empty(); }));
  ASSERT_EQ(test::say(**raw, "other"), transport_dds::Writer::Sent::Yes);
  EXPECT_TRUE(until([&] { return there.stats().stray == 1; }));
  EXPECT_EQ(reader->writer_count(), 0U);
}

TEST_F(Mirror, tells_of_a_remote_writers_missed_deadline) {
  const QoS qos = QoS(1).deadline(50ms);
  auto reader = there.reader("/deadline", qos);
  auto writer = here.writer("/deadline", qos);
  ASSERT_TRUE(joined(*writer, *reader));
  say(*writer, "the clock starts");
  EXPECT_TRUE(there.bell.until([&] { return reader->status().deadline_missed != 0; }));
}

TEST_F(Mirror, tells_of_a_remote_writers_lost_liveliness_and_of_its_return) {
  const QoS qos = QoS(1).liveliness(Liveliness::ManualByTopic).liveliness_lease_duration(300ms);
  auto reader = there.reader("/life", qos);
  auto writer = here.writer("/life", qos);
  ASSERT_TRUE(joined(*writer, *reader));
  say(*writer, "alive");
  ASSERT_TRUE(there.bell.until([&] { return reader->status().alive == 1; }));
  ASSERT_TRUE(there.bell.until([&] { return reader->status().not_alive == 1; }));
  say(*writer, "again");
  EXPECT_TRUE(there.bell.until([&] { return reader->status().alive == 1; }));
}

TEST_F(Mirror, survives_ends_that_come_and_go_under_traffic) {
  std::atomic<bool> stop{false};
  std::thread talker([&] {
    int n = 0;
    const auto talk = [&](Writer& writer, int count) {
      for (int i = 0; i < count && !stop; ++i) {
        say(writer, std::to_string(++n));
        std::this_thread::yield();
      }
    };
    for (int made = 0; !stop; ++made) {
      auto writer = here.writer("/busy", QoS(5));
      talk(*writer, 200);
      // Most have ended before the network knows of them, above all on a busy machine; some wait until they are heard.
      while (made % 20 == 0 && !stop && writer->reader_count() == 0) talk(*writer, 1);
      talk(*writer, 20);
    }
  });
  std::size_t heard = 0;
  for (int round = 0; round < 30; ++round) {
    auto one = there.reader("/busy", QoS(5));
    auto two = there.reader("/busy", QoS(5), Taking::Own);
    if (round % 10 == 0) {
      heard += hear(there.bell, *one, 1).size();
      heard += hear(there.bell, *two, 1).size();
    }
  }
  stop = true;
  talker.join();
  EXPECT_GE(heard, 6U);
  EXPECT_EQ(there.stats().broken, 0U);
  EXPECT_TRUE(until([&] {
    const MirrorStats a = here.stats(), b = there.stats();
    return a.writers + a.readers + a.taps + a.stand_ins + b.writers + b.readers + b.taps + b.stand_ins == 0;
  }));
}

}  // namespace
}  // namespace nacelle
