// SPDX-License-Identifier: Apache-2.0
#include "record/model/ordered_messages.hpp"

#include <gtest/gtest.h>

#include "record/protocol/mcap_codec.hpp"
#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

/// Messages "TIME" on a topic, a chunk for each list of times.
MemoryFile file_of(const std::vector<std::vector<std::uint64_t>>& chunks, const std::string& topic = "/a",
                   Compression compression = Compression::None) {
  MemoryFile file;
  McapWriter writer{file, {.compression = compression}};
  EXPECT_TRUE(writer.start());
  const auto schema = writer.add_schema("std_msgs/msg/String", "ros2msg", "string data\n");
  const auto channel = writer.add_channel(*schema, topic, "cdr", {{"key", "value"}});
  for (const auto& times : chunks) {
    for (const std::uint64_t time : times) {
      const std::string text = std::to_string(time);
      EXPECT_TRUE(writer.write({*channel, 7, time, time + 1, {as_bytes(text)}}));
    }
    EXPECT_TRUE(writer.close_chunk());
  }
  EXPECT_TRUE(writer.finish());
  return MemoryFile{file.bytes};
}

std::string all_of(OrderedMessages& messages) {
  std::string text;
  while (const auto* message = messages.next()) {
    EXPECT_EQ(as_text(message->data), std::to_string(message->log_time));
    EXPECT_EQ(message->publish_time, message->log_time + 1);
    EXPECT_EQ(message->sequence, 7U);
    text += messages.topics()[message->topic].name + std::to_string(message->log_time) + " ";
  }
  return text;
}

TEST(OrderedMessages, come_in_the_order_of_their_times) {
  MemoryFile a = file_of({{10, 30, 20}, {25, 60}, {}, {40}}), b = file_of({{5, 35}, {100}}, "/b", Compression::Zstd);
  auto made = OrderedMessages::open({&a, &b});
  ASSERT_TRUE(made);
  OrderedMessages& messages = **made;
  EXPECT_EQ(messages.first(), 5U);
  EXPECT_EQ(messages.last(), 100U);
  EXPECT_EQ(messages.messages(), 9U);
  ASSERT_EQ(messages.topics().size(), 2U);
  EXPECT_EQ(
      messages.topics()[0],
      (OrderedMessages::Topic{"/a", "std_msgs/msg/String", "cdr", "ros2msg", "string data\n", {{"key", "value"}}}));
  EXPECT_EQ(all_of(messages), "/b5 /a10 /a20 /a25 /a30 /b35 /a40 /a60 /b100 ");
  EXPECT_EQ(messages.next(), nullptr);
  messages.seek(30);
  EXPECT_EQ(all_of(messages), "/a30 /b35 /a40 /a60 /b100 ");
  messages.seek(0);
  EXPECT_EQ(all_of(messages).substr(0, 9), "/b5 /a10 ");
  messages.seek(101);
  EXPECT_EQ(messages.next(), nullptr);
  EXPECT_TRUE(messages.problems().empty());
}

TEST(OrderedMessages, of_one_time_keep_their_order_and_equal_channels_are_one_topic) {
  MemoryFile a = file_of({{10, 10}}), b = file_of({{10}});
  auto made = OrderedMessages::open({&a, &b});
  ASSERT_TRUE(made);
  EXPECT_EQ((*made)->topics().size(), 1U);
  EXPECT_EQ(all_of(**made), "/a10 /a10 /a10 ");
}

TEST(OrderedMessages, of_a_damaged_chunk_are_left_out) {
  MemoryFile a = file_of({{10, 20}, {30}});
  const SeenFile seen{a};
  a.bytes[seen.chunk_spots[0].offset + seen.chunk_spots[0].length - 2] ^= 1;
  auto made = OrderedMessages::open({&a});
  ASSERT_TRUE(made);
  EXPECT_EQ(all_of(**made), "/a30 ");
  ASSERT_EQ((*made)->problems().size(), 1U);
  EXPECT_EQ((*made)->problems()[0].problem.fault, McapFault::BadCrc);
}

// As `mcap` writers may leave them: without summary and indexes, and without chunks.
MemoryFile bare_file(bool has_chunk) {
  Bytes all(std::begin(kMcapMagic), std::end(kMcapMagic)), inside;
  append_record(McapHeader{"ros2", "test"}, all);
  append_record(McapSchema{1, "std_msgs/msg/String", "ros2msg", {as_bytes("string data\n")}}, inside);
  append_record(McapChannel{1, 1, "/a", "cdr", {}}, inside);
  for (const char* text : {"30", "10", "20"}) {
    const auto time = static_cast<std::uint64_t>(std::stoi(text));
    append_record(McapMessage{1, 7, time, time + 1, {as_bytes(text)}}, inside);
  }
  if (has_chunk) append_record(McapChunk{10, 30, inside.size(), 0, "", {inside}}, all);
  if (!has_chunk) all.insert(all.end(), inside.begin(), inside.end());
  append_record(McapDataEnd{}, all);
  append_record(McapFooter{}, all);
  all.insert(all.end(), std::begin(kMcapMagic), std::end(kMcapMagic));
  return MemoryFile{all};
}

TEST(OrderedMessages, need_neither_summary_nor_chunks) {
  for (const bool has_chunk : {true, false}) {
    MemoryFile file = bare_file(has_chunk);
    auto made = OrderedMessages::open({&file});
    ASSERT_TRUE(made) << made.error().problem.what;
    EXPECT_EQ((*made)->messages(), 3U);
    EXPECT_EQ((*made)->first(), 10U);
    EXPECT_EQ((*made)->last(), 30U);
    EXPECT_EQ(all_of(**made), "/a10 /a20 /a30 ");
    (*made)->seek(20);
    EXPECT_EQ(all_of(**made), "/a20 /a30 ");
  }
}

TEST(OrderedMessages, need_an_end) {
  MemoryFile a = file_of({{10}}), cut = file_of({{10}});
  cut.bytes.resize(cut.bytes.size() - 1);
  const auto refused = OrderedMessages::open({&a, &cut});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().file, 1U);
  EXPECT_EQ(refused.error().problem.fault, McapFault::Truncated);
  MemoryFile words{Bytes(100, 'x')}, nothing;
  EXPECT_EQ(OrderedMessages::open({&words}).error().problem.fault, McapFault::NoMagic);
  EXPECT_EQ(OrderedMessages::open({&nothing}).error().problem.fault, McapFault::NoMagic);
}

// Each place of a file damaged in turn: nothing is read beyond the file, and no message is made up.
TEST(OrderedMessages, survive_every_wrong_byte) {
  const MemoryFile whole = file_of({{10, 20}, {15}});
  for (std::size_t at = 0; at < whole.bytes.size(); ++at) {
    for (const std::uint8_t flip : {0x01, 0x80, 0xFF}) {
      MemoryFile file{whole.bytes};
      file.bytes[at] ^= flip;
      auto made = OrderedMessages::open({&file});
      if (!made) continue;
      int count = 0;
      while ((*made)->next() != nullptr) ++count;
      EXPECT_LE(count, 3);
    }
  }
}

}  // namespace
}  // namespace nacelle::record
