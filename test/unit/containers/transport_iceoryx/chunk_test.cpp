// SPDX-License-Identifier: Apache-2.0
#include "transport_iceoryx/wire/chunk.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "transport_iceoryx/wire/stream_name.hpp"

namespace nacelle::transport_iceoryx {
namespace {

/// A chunk's bytes at an address that numbers of eight bytes may have.
class Chunk {
 public:
  explicit Chunk(std::size_t size) : words_((size + 7) / 8), size_(size) {}
  [[nodiscard]] std::uint8_t* begin() { return reinterpret_cast<std::uint8_t*>(words_.data()); }
  [[nodiscard]] ByteView view(std::size_t size) { return {begin(), size}; }
  [[nodiscard]] ByteView view() { return view(size_); }

 private:
  std::vector<std::uint64_t> words_;
  std::size_t size_;
};

constexpr Stamp kStamp{3, 4, -5, 6};

Chunk chunk_with(std::initializer_list<PartPlace> places, std::size_t size = 20'000, std::uint32_t small_bytes = 10) {
  Chunk chunk(size);
  write_head(chunk.begin(), kStamp, small_bytes, std::vector<PartPlace>(places));
  return chunk;
}

TEST(IceoryxChunk, says_what_was_written) {
  Chunk chunk = chunk_with({{64, 5000}, {8192, 4096}});

  const auto view = read_chunk(chunk.view());

  ASSERT_TRUE(view);
  EXPECT_EQ(view->stamp.writer_id, 3U);
  EXPECT_EQ(view->stamp.sequence, 4U);
  EXPECT_EQ(view->stamp.source_ns, -5);
  EXPECT_EQ(view->stamp.expires_ns, 6);
  EXPECT_EQ(view->small.data(), chunk.begin() + 64);
  EXPECT_EQ(view->small.size(), 10U);
  ASSERT_EQ(view->parts, 2U);
  EXPECT_EQ(view->places[1].offset, 8192U);
  EXPECT_EQ(view->places[1].bytes, 4096U);
}

TEST(IceoryxChunk, that_is_cut_anywhere_before_its_end_is_refused) {
  Chunk chunk = chunk_with({{128, 100}});
  for (std::size_t size = 0; size < 228; ++size)
    EXPECT_EQ(read_chunk(chunk.view(size)).error(), ChunkFault::Truncated) << size;
  EXPECT_TRUE(read_chunk(chunk.view(228)));
}

TEST(IceoryxChunk, whose_announcements_reach_beyond_it_is_refused) {
  EXPECT_EQ(read_chunk(chunk_with({{0xFFFF'FFF8, 1}}).view()).error(), ChunkFault::Truncated);
  EXPECT_EQ(read_chunk(chunk_with({{64, 0xFFFF'FFFF}}).view()).error(), ChunkFault::Truncated);
  EXPECT_EQ(read_chunk(chunk_with({{65, 10}}).view()).error(), ChunkFault::Misaligned);
  EXPECT_EQ(read_chunk(chunk_with({}, 100, 0xFFFF'FFFF).view()).error(), ChunkFault::Truncated);
}

TEST(IceoryxChunk, of_another_program_or_version_is_refused) {
  Chunk other = chunk_with({}), version = chunk_with({}), many = chunk_with({});
  other.begin()[0] = 'X';
  version.begin()[4] = 2;
  many.begin()[6] = 17;

  EXPECT_EQ(read_chunk(other.view()).error(), ChunkFault::NotOurs);
  EXPECT_EQ(read_chunk(version.view()).error(), ChunkFault::OtherVersion);
  EXPECT_EQ(read_chunk(many.view()).error(), ChunkFault::TooManyParts);
  EXPECT_EQ(read_chunk(other.view().subspan(1)).error(), ChunkFault::Misaligned);
}

TEST(IceoryxChunk, is_planned_without_overlap_and_aligned) {
  msgs::PartList parts;
  parts.parts[0].bytes = 4097;
  parts.parts[1].bytes = 5000;
  parts.count = 2;

  const ChunkPlan plan = plan_chunk(33, parts, 100);

  EXPECT_EQ(plan.small_offset, 64U);
  EXPECT_EQ(plan.part_offsets[0], 256U) << "behind 64 + 33 + 100 bytes, a multiple of 64";
  EXPECT_EQ(plan.part_offsets[1], 4416U);
  EXPECT_EQ(plan.bytes, 9416U);
}

TEST(IceoryxStreamName, is_kept_while_iceoryx_does_not_cut_it) {
  const std::string longest(100, 'x');
  EXPECT_EQ(short_name("/scan"), "/scan");
  EXPECT_EQ(short_name(longest), longest);
}

TEST(IceoryxStreamName, that_is_too_long_keeps_its_end_and_a_hash_of_all) {
  const std::string a = std::string(120, 'x') + "/camera", b = "y" + a;

  EXPECT_EQ(short_name(a).size(), kMostNameBytes);
  EXPECT_TRUE(short_name(a).ends_with("x/camera"));
  EXPECT_NE(short_name(a), short_name(b));
  EXPECT_EQ(short_name(a), short_name(a));
}

}  // namespace
}  // namespace nacelle::transport_iceoryx
