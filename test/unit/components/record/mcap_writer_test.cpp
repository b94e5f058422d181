// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/mcap_writer.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "seen_file.hpp"
#include "support/allocation_guard.hpp"

namespace nacelle::record {
namespace {

McapMessage message_of(std::uint16_t channel, std::uint32_t sequence, std::uint64_t at, std::string_view data) {
  return {channel, sequence, at, at - 5, {as_bytes(data)}};
}

/// Two channels of one schema, three messages in two chunks, an attachment and metadata.
void write_small(McapWriter& writer) {
  ASSERT_TRUE(writer.start());
  const auto schema = writer.add_schema("std_msgs/msg/String", "ros2msg", "string data");
  ASSERT_EQ(schema, 1);
  EXPECT_EQ(writer.add_schema("std_msgs/msg/String", "ros2msg", "string data"), schema);
  ASSERT_EQ(writer.add_channel(*schema, "/a", "cdr", {{"k", "v"}}), 1);
  ASSERT_EQ(writer.add_channel(*schema, "/b", "cdr", {}), 2);
  EXPECT_TRUE(writer.write(message_of(1, 1, 1000, "one")));
  EXPECT_TRUE(writer.write(message_of(2, 1, 900, "two")));
  EXPECT_TRUE(writer.close_chunk());
  EXPECT_TRUE(writer.close_chunk()) << "an empty chunk is not written";
  EXPECT_TRUE(writer.write_attachment({1000, 1001, "robot.launch.yaml", "text/yaml", {as_bytes("launch:")}, 0}));
  EXPECT_TRUE(writer.write_metadata({"rosbag2", {{"ros_distro", "jazzy"}}}));
  EXPECT_TRUE(writer.write(message_of(1, 2, 2000, "three")));
  EXPECT_TRUE(writer.finish());
  EXPECT_FALSE(writer.write(message_of(1, 3, 3000, "after the end")));
  EXPECT_FALSE(writer.finish());
}

TEST(McapWriter, hands_a_chunk_with_its_indexes_over_as_one_piece) {
  MemoryFile file;
  McapWriter writer{file, {}};
  ASSERT_TRUE(writer.start());
  ASSERT_EQ(writer.add_channel(*writer.add_schema("a/msg/B", "ros2msg", ""), "/a", "cdr", {}), 1);
  const int before = file.writes;
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_TRUE(writer.write(message_of(1, i, i, "message")));
  EXPECT_EQ(file.writes, before);
  EXPECT_TRUE(writer.close_chunk());
  EXPECT_EQ(file.writes, before + 1);
}

class Written : public testing::TestWithParam<Compression> {};

TEST_P(Written, is_read_again) {
  MemoryFile file;
  McapWriter writer{file, {.compression = GetParam()}};
  write_small(writer);
  EXPECT_EQ(writer.written(), file.bytes.size());
  EXPECT_EQ(writer.messages(), 3U);

  const SeenFile seen{file};
  EXPECT_TRUE(seen.complete);
  const std::string name = mcap_name(GetParam());
  EXPECT_EQ(seen.lines, (std::vector<std::string>{
                            "header ros2 nacelle",
                            "chunk 900..1000 '" + name + "'",
                            "schema 1 std_msgs/msg/String ros2msg string data",
                            "channel 1 of 1 /a cdr k=v",
                            "message 1 #1 at 1000 of 995: one",
                            "channel 2 of 1 /b cdr",
                            "message 2 #1 at 900 of 895: two",
                            "attachment robot.launch.yaml text/yaml: launch:",
                            "metadata rosbag2 ros_distro=jazzy",
                            "chunk 2000..2000 '" + name + "'",
                            "message 1 #2 at 2000 of 1995: three",
                        }));
  EXPECT_EQ(seen.spots, seen.indexes) << "each message's index leads to it";
  EXPECT_EQ(seen.statistics.message_count, 3U);
  EXPECT_EQ(seen.statistics.chunk_count, 2U);
  EXPECT_EQ(seen.statistics.channel_count, 2U);
  EXPECT_EQ(seen.statistics.schema_count, 1U);
  EXPECT_EQ(seen.statistics.attachment_count, 1U);
  EXPECT_EQ(seen.statistics.metadata_count, 1U);
  EXPECT_EQ(seen.statistics.message_start_time, 900U);
  EXPECT_EQ(seen.statistics.message_end_time, 2000U);
  EXPECT_EQ(seen.statistics.channel_message_counts, (std::map<std::uint16_t, std::uint64_t>{{1, 2}, {2, 1}}));
  ASSERT_EQ(seen.chunk_indexes.size(), 2U);
  for (std::size_t at = 0; at < 2; ++at) {
    EXPECT_EQ(seen.chunk_indexes[at].chunk_start_offset, seen.chunk_spots[at].offset);
    EXPECT_EQ(seen.chunk_indexes[at].chunk_length, seen.chunk_spots[at].length);
  }
  EXPECT_EQ(seen.chunk_indexes[0].message_index_offsets.size(), 2U);
  EXPECT_EQ(seen.chunk_indexes[0].message_index_offsets.at(1), seen.chunk_spots[0].offset + seen.chunk_spots[0].length);
  EXPECT_EQ(seen.groups.size(), 6U);
  const std::size_t crc_at = file.bytes.size() - sizeof kMcapMagic - 4;
  EXPECT_EQ(seen.footer.summary_crc,
            crc32_of(ByteView{file.bytes}.subspan(seen.footer.summary_start, crc_at - seen.footer.summary_start)));
}

INSTANTIATE_TEST_SUITE_P(All, Written, testing::Values(Compression::None, Compression::Lz4, Compression::Zstd));

// Assembled by hand from the specification's tables.
TEST(McapWriter, writes_the_bytes_of_the_specification) {
  MemoryFile file;
  McapWriter writer{file, {.profile = "p", .library = "l"}};
  ASSERT_TRUE(writer.start());
  ASSERT_EQ(writer.add_channel(0, "/t", "cdr", {}), 1);
  ASSERT_TRUE(writer.write({1, 7, 0x10, 0x0F, {as_bytes("xy")}}));
  ASSERT_TRUE(writer.close_chunk());
  Bytes expected;
  ASSERT_TRUE(
      from_hex("894D434150300D0A"                                       // magic
               "01 0A00000000000000 01000000 70 01000000 6C"            // Header
               "06 6E00000000000000 1000000000000000 1000000000000000"  // Chunk: times
               "3E00000000000000",                                      // uncompressed size
               expected));
  Bytes records;
  ASSERT_TRUE(
      from_hex("04 1500000000000000 0100 0000 02000000 2F74 03000000 636472 00000000"  // Channel
               "05 1800000000000000 0100 07000000 1000000000000000 0F00000000000000 7879",
               records));  // Message
  EXPECT_EQ(records.size(), 0x3FU);
  EXPECT_EQ(to_hex(ByteView{file.bytes}.first(27)), to_hex(ByteView{expected}.first(27)));
  const auto at = std::search(file.bytes.begin(), file.bytes.end(), records.begin(), records.end());
  EXPECT_NE(at, file.bytes.end());
}

TEST(McapWriter, encodes_a_message_in_its_place) {
  MemoryFile file;
  McapWriter writer{file, {}};
  ASSERT_TRUE(writer.start());
  ASSERT_TRUE(writer.add_channel(0, "/t", "cdr", {}));
  EXPECT_TRUE(writer.write({1, 1, 10, 10, {}}, 3, [](ByteSpan to) {
    ASSERT_EQ(to.size(), 3U);
    std::memcpy(to.data(), "abc", 3);
  }));
  EXPECT_TRUE(writer.write({1, 2, 11, 11, {}}, 0, [](ByteSpan to) { EXPECT_TRUE(to.empty()); }));
  ASSERT_TRUE(writer.finish());
  const SeenFile seen{file};
  EXPECT_EQ(seen.lines.at(3), "message 1 #1 at 10 of 10: abc");
  EXPECT_EQ(seen.lines.at(4), "message 1 #2 at 11 of 11: ");
  EXPECT_TRUE(seen.problems.empty());
}

TEST(McapWriter, closes_a_chunk_at_its_size) {
  MemoryFile file;
  McapWriter writer{file, {.chunk_bytes = 1000}};
  ASSERT_TRUE(writer.start());
  ASSERT_TRUE(writer.add_channel(0, "/t", "cdr", {}));
  const std::string text(300, 'x');
  for (std::uint32_t number = 1; number <= 9; ++number)
    ASSERT_TRUE(writer.write({1, number, number, number, {as_bytes(text)}}));
  ASSERT_TRUE(writer.finish());
  const SeenFile seen{file};
  EXPECT_EQ(seen.chunk_spots.size(), 3U) << "331 bytes a message, and the channel before the first";
  EXPECT_EQ(seen.statistics.message_count, 9U);
}

TEST(McapWriter, a_full_disk_ends_it_and_leaves_what_was_closed) {
  MemoryFile file;
  McapWriter writer{file, {}};
  ASSERT_TRUE(writer.start());
  ASSERT_TRUE(writer.add_channel(0, "/t", "cdr", {}));
  ASSERT_TRUE(writer.write(message_of(1, 1, 10, "kept")));
  ASSERT_TRUE(writer.close_chunk());
  file.room = file.bytes.size() + 10;
  ASSERT_TRUE(writer.write(message_of(1, 2, 20, "lost")));
  EXPECT_FALSE(writer.close_chunk());
  const int writes = file.writes;
  EXPECT_FALSE(writer.write(message_of(1, 3, 30, "lost")));
  EXPECT_FALSE(writer.finish());
  EXPECT_FALSE(writer.add_channel(0, "/u", "cdr", {}));
  EXPECT_EQ(file.writes, writes) << "nothing is written after a failure";
  const SeenFile seen{file};
  EXPECT_EQ(seen.problems, std::vector{McapFault::Truncated});
  EXPECT_EQ(seen.lines.at(3), "message 1 #1 at 10 of 5: kept");
}

TEST(McapWriter, knows_no_channel_that_was_not_added) {
  MemoryFile file;
  McapWriter writer{file, {}};
  ASSERT_TRUE(writer.start());
  EXPECT_FALSE(writer.write(message_of(1, 1, 10, "x")));
  EXPECT_EQ(writer.add_channel(1, "/t", "cdr", {}), std::nullopt) << "no such schema";
}

TEST(McapWriter, takes_no_memory_for_a_message) {
  MemoryFile file;
  file.bytes.reserve(std::size_t{1} << 20U);
  McapWriter writer{file, {.chunk_bytes = 100000}};
  ASSERT_TRUE(writer.start());
  ASSERT_TRUE(writer.add_channel(0, "/t", "cdr", {}));
  const std::string text(200, 'x');
  const auto fill_a_chunk = [&] {
    bool all = true;
    for (std::uint32_t number = 0; number < 400; ++number)
      all = all && writer.write(message_of(1, number, 10 + number, text));
    return all;
  };
  ASSERT_TRUE(fill_a_chunk());
  ASSERT_TRUE(writer.close_chunk());
  const test::AllocationGuard guard;
  const bool all = fill_a_chunk();
  const auto allocations = guard.count();
  EXPECT_TRUE(all);
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace nacelle::record
