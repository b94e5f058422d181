// SPDX-License-Identifier: Apache-2.0
#include "record/protocol/mcap_walk.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "record/protocol/compression.hpp"
#include "record/protocol/mcap_codec.hpp"
#include "record/protocol/mcap_writer.hpp"
#include "seen_file.hpp"

namespace nacelle::record {
namespace {

using Faults = std::vector<McapFault>;

Bytes magic() { return {std::begin(kMcapMagic), std::end(kMcapMagic)}; }
void append_magic(Bytes& out) { out.insert(out.end(), std::begin(kMcapMagic), std::end(kMcapMagic)); }
/// A whole file of these records, which have no summary.
template <class... Records>
Bytes file_of(const Records&... records) {
  Bytes out = magic();
  append_record(McapHeader{}, out);
  (append_record(records, out), ...);
  append_record(McapDataEnd{}, out);
  append_record(McapFooter{}, out);
  append_magic(out);
  return out;
}
template <class... Records>
Bytes records_of(const Records&... records) {
  Bytes out;
  (append_record(records, out), ...);
  return out;
}
McapChunk chunk_of(ByteView records) { return {1, 2, records.size(), crc32_of(records), "", {records}}; }
Faults faults_of(Bytes bytes) {
  MemoryFile file{std::move(bytes)};
  return SeenFile{file}.problems;
}

const McapSchema kSchema{1, "s", "ros2msg", {as_bytes("x")}};
const McapChannel kChannel{3, 1, "/t", "cdr", {}};
const McapMessage kMessage{3, 1, 10, 10, {as_bytes("m")}};

TEST(McapWalk, reads_messages_outside_of_chunks_and_skips_what_it_does_not_know) {
  Bytes bytes = file_of(kSchema, kChannel, kMessage);
  const Bytes unknown{0x80, 2,    0, 0, 0, 0, 0, 0, 0, 1,
                      2,    0x10, 0, 0, 0, 0, 0, 0, 0, 0};  // private, and a later version's
  bytes.insert(bytes.begin() + sizeof kMcapMagic, unknown.begin(), unknown.end());
  MemoryFile file{bytes};
  const SeenFile seen{file};
  EXPECT_TRUE(seen.complete);
  EXPECT_EQ(seen.problems, Faults{});
  EXPECT_EQ(seen.lines.back(), "message 3 #1 at 10 of 10: m");
}

TEST(McapWalk, ignores_fields_of_later_versions) {
  Bytes inside;
  append_record(kSchema, inside);
  inside.push_back(0xFF);
  inside[1] += 1;  // the length of its content
  MemoryFile file{file_of(chunk_of(inside))};
  const SeenFile seen{file};
  EXPECT_EQ(seen.problems, Faults{});
  EXPECT_EQ(seen.lines.back(), "schema 1 s ros2msg x");
}

TEST(McapWalk, names_what_is_wrong) {
  EXPECT_EQ(faults_of({}), Faults{McapFault::NoMagic});
  EXPECT_EQ(faults_of(Bytes(100, 'x')), Faults{McapFault::NoMagic});
  EXPECT_EQ(faults_of(magic()), Faults{McapFault::Truncated});
  EXPECT_EQ(faults_of(file_of(kMessage)), Faults{McapFault::UnknownChannel});
  EXPECT_EQ(faults_of(file_of(kChannel)), Faults{McapFault::UnknownChannel}) << "of an unknown schema";
  EXPECT_EQ(faults_of(file_of(McapSchema{})), Faults{McapFault::BadRecord}) << "id 0";
  McapSchema other = kSchema;
  other.name = "t";
  EXPECT_EQ(faults_of(file_of(kSchema, kSchema, other)), Faults{McapFault::Conflict});

  const Bytes records = records_of(kSchema, kChannel, kMessage);
  EXPECT_EQ(faults_of(file_of(chunk_of(records))), Faults{});
  McapChunk chunk = chunk_of(records);
  ++chunk.uncompressed_crc;
  EXPECT_EQ(faults_of(file_of(chunk)), Faults{McapFault::BadCrc});
  chunk.uncompressed_crc = 0;
  EXPECT_EQ(faults_of(file_of(chunk)), Faults{}) << "0: it has none";
  chunk.compression = "bz2";
  EXPECT_EQ(faults_of(file_of(chunk)), Faults{McapFault::UnknownCompression});
  for (const char* name : {"lz4", "zstd"}) {
    chunk.compression = name;
    EXPECT_EQ(faults_of(file_of(chunk)), Faults{McapFault::BadCompression});
  }
  chunk.uncompressed_size = kMostMcapRecordBytes + 1;
  EXPECT_EQ(faults_of(file_of(chunk)), Faults{McapFault::TooLarge});
  EXPECT_EQ(faults_of(file_of(chunk_of(records_of(McapHeader{})))), Faults{McapFault::BadRecord});
  EXPECT_EQ(faults_of(file_of(chunk_of(ByteView{records}.first(records.size() - 1)))), Faults{McapFault::BadRecord});
  McapAttachment attachment{1, 2, "n", "m", {as_bytes("data")}, 17};
  EXPECT_EQ(faults_of(file_of(attachment)), Faults{McapFault::BadCrc});

  Bytes more = file_of();
  more.push_back(0);
  EXPECT_EQ(faults_of(more), Faults{McapFault::BadRecord});
  more.resize(more.size() - 2);
  EXPECT_EQ(faults_of(more), Faults{McapFault::Truncated});
}

TEST(McapWalk, goes_on_behind_a_chunk_that_it_cannot_read) {
  const Bytes first = records_of(kSchema, kChannel), second = records_of(kMessage);
  McapChunk broken = chunk_of(second);
  broken.compression = "zstd";
  MemoryFile file{file_of(chunk_of(first), broken, chunk_of(second))};
  const SeenFile seen{file};
  EXPECT_TRUE(seen.complete);
  EXPECT_EQ(seen.problems, Faults{McapFault::BadCompression});
  EXPECT_EQ(seen.lines.back(), "message 3 #1 at 10 of 10: m");
}

/// A file that was cut at any byte has a problem, and loses no chunk that was whole.
TEST(McapWalk, reads_what_is_there_of_a_file_that_was_cut_anywhere) {
  MemoryFile file;
  McapWriter writer{file, {.compression = Compression::Lz4}};
  ASSERT_TRUE(writer.start());
  ASSERT_TRUE(writer.add_channel(0, "/t", "cdr", {}));
  std::vector<std::size_t> closed;
  for (std::uint32_t number = 1; number <= 3; ++number) {
    ASSERT_TRUE(writer.write({1, number, number, number, {as_bytes("data")}}));
    ASSERT_TRUE(writer.close_chunk());
    closed.push_back(file.bytes.size());
  }
  ASSERT_TRUE(writer.finish());
  for (std::size_t size = 0; size < file.bytes.size(); ++size) {
    MemoryFile cut{Bytes(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(size))};
    const SeenFile seen{cut};
    EXPECT_FALSE(seen.complete) << size;
    EXPECT_EQ(seen.problems.size(), 1U) << size;
    const auto whole = std::count_if(closed.begin(), closed.end(), [&](std::size_t end) { return end <= size; });
    EXPECT_GE(seen.spots.size(), static_cast<std::size_t>(whole)) << size;
  }
}

}  // namespace
}  // namespace nacelle::record
