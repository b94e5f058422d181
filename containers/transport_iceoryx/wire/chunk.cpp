// SPDX-License-Identifier: Apache-2.0
#include "transport_iceoryx/wire/chunk.hpp"

#include <cstring>

namespace nacelle::transport_iceoryx {
namespace {

struct Head {
  std::array<char, 4> magic;
  std::uint16_t version;
  std::uint16_t parts;
  std::uint32_t small_bytes;
  std::uint32_t zero;
  Stamp stamp;
};
static_assert(sizeof(Head) == kHeadBytes && sizeof(PartPlace) == kPlaceBytes);

constexpr std::array<char, 4> kMagic{'N', 'C', 'L', 'X'};
constexpr std::uint16_t kVersion = 1;
constexpr std::size_t kWidestNumber = 8;

std::size_t aligned(std::size_t offset) { return (offset + kPartAlignment - 1) & ~(kPartAlignment - 1); }

}  // namespace

ChunkPlan plan_chunk(std::size_t small_bytes, const msgs::PartList& parts, std::size_t spare) {
  ChunkPlan plan;
  plan.parts = parts.count;
  plan.small_offset = small_offset_of(parts.count);
  plan.bytes = plan.small_offset + small_bytes + spare;
  for (std::size_t i = 0; i < parts.count; ++i) {
    plan.part_offsets[i] = aligned(plan.bytes);
    plan.bytes = plan.part_offsets[i] + parts.parts[i].bytes;
  }
  return plan;
}

void write_head(std::uint8_t* chunk, const Stamp& stamp, std::uint32_t small_bytes, std::span<const PartPlace> places) {
  const Head head{kMagic, kVersion, static_cast<std::uint16_t>(places.size()), small_bytes, 0, stamp};
  std::memcpy(chunk, &head, sizeof head);
  if (!places.empty()) std::memcpy(chunk + kHeadBytes, places.data(), places.size_bytes());
}

Result<ChunkView, ChunkFault> read_chunk(ByteView chunk) {
  if (chunk.size() < kHeadBytes) return err(ChunkFault::Truncated);
  if (reinterpret_cast<std::uintptr_t>(chunk.data()) % kWidestNumber != 0) return err(ChunkFault::Misaligned);
  Head head;
  std::memcpy(&head, chunk.data(), sizeof head);
  if (head.magic != kMagic) return err(ChunkFault::NotOurs);
  if (head.version != kVersion) return err(ChunkFault::OtherVersion);
  if (head.parts > msgs::kMostParts) return err(ChunkFault::TooManyParts);
  const std::size_t small_offset = small_offset_of(head.parts);
  if (chunk.size() < small_offset || chunk.size() - small_offset < head.small_bytes) return err(ChunkFault::Truncated);
  ChunkView view{head.stamp, chunk.subspan(small_offset, head.small_bytes), head.parts, {}};
  if (head.parts != 0) std::memcpy(view.places.data(), chunk.data() + kHeadBytes, head.parts * kPlaceBytes);
  for (std::size_t i = 0; i < view.parts; ++i) {
    const PartPlace place = view.places[i];
    if (place.offset > chunk.size() || chunk.size() - place.offset < place.bytes) return err(ChunkFault::Truncated);
    if (place.offset % kWidestNumber != 0) return err(ChunkFault::Misaligned);
  }
  return view;
}

const char* explain(ChunkFault fault) {
  switch (fault) {
    case ChunkFault::Truncated: return "the chunk is shorter than it says";
    case ChunkFault::Misaligned: return "the chunk or a part of it is not aligned";
    case ChunkFault::NotOurs: return "the chunk does not begin with NCLX";
    case ChunkFault::OtherVersion: return "the chunk has another version: both processes must be of one release";
    case ChunkFault::TooManyParts: return "the chunk announces more than 16 parts";
  }
  return "unknown fault";
}

}  // namespace nacelle::transport_iceoryx
