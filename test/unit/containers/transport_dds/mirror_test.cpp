// SPDX-License-Identifier: Apache-2.0
// Messages between two graphs in one process that only the network joins.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <sensor_msgs/msg/image.hpp>

#include "mirrored.hpp"

namespace nacelle {
namespace {

using test::hear;
using test::Mirror;
using test::say;
using test::Texts;

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

TEST_F(Mirror, delivers_writer_time_and_sequence_of_a_message) {
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
  EXPECT_EQ(hear(*late), Texts{}) << "history for a new reader is not sent to the others again";
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

TEST_F(Mirror, neither_fetches_nor_encodes_without_a_remote_reader) {
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
  EXPECT_EQ(here.stats().encoded, 1U) << "one message, and no earlier one";

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
  EXPECT_TRUE(until([&] { return here.stats().encoded >= 50 * rounds; })) << "counted when it is gone";
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

TEST_F(Mirror, brings_an_image_of_eight_megabytes_whole) {
  using sensor_msgs::msg::Image;
  EndpointSpec image = there.spec("/image", QoS(2));
  image.type = &Image::message_type();
  auto reader = there.broker.create_reader(image, Taking::Share, &there.bell);
  image = here.spec("/image", QoS(2));
  image.type = &Image::message_type();
  auto writer = here.broker.create_writer(image);
  ASSERT_TRUE(joined(*writer, *reader));
  const auto hear_one = [&](const Image& said) {
    Block* const block = writer->borrow();
    *static_cast<Image*>(block->message) = said;
    writer->publish(*block);
    ASSERT_TRUE(there.bell.until([&] { return reader->has_waiting(); }));
    Block* const got = reader->take();
    EXPECT_TRUE(*static_cast<const Image*>(got->message) == said);
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

}  // namespace
}  // namespace nacelle
