// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/msgs/cdr_apart.hpp"

// The layout of a message in a chunk of shared memory. Both ends run on one host, so numbers have its byte order.
//
//   offset  bytes  field       becomes
//        0      4  magic       "NCLX"
//        4      2  version     1
//        6      2  parts       n, at most 16
//        8      4  small       bytes of the small body
//       12      4  -           0
//       16      8  writer      MessageInfo::writer_id
//       24      8  sequence    MessageInfo::sequence
//       32      8  source      ns of CLOCK_MONOTONIC, MessageInfo::source_time
//       40      8  expires     ns of CLOCK_MONOTONIC, Block::expires
//       48    8*n  places      of each part: u32 offset from the chunk's start, u32 bytes
//   48+8*n  small  small body  CDR without its parts (nacelle/msgs/cdr_apart.hpp)
//        …      …  parts       each at a multiple of 64 bytes, in the layout of its sequence in memory
namespace nacelle::transport_iceoryx {

inline constexpr std::size_t kHeadBytes = 48, kPlaceBytes = 8;
inline constexpr std::size_t kPartAlignment = 64;

/// Why a chunk does not hold a message of Nacelle.
enum class ChunkFault : std::uint8_t {
  Truncated,   ///< Shorter than its head, or than the head announces.
  Misaligned,  ///< The chunk or a part is not aligned to eight bytes.
  NotOurs,     ///< Wrong magic: written by another program.
  OtherVersion,
  TooManyParts,
};
[[nodiscard]] const char* explain(ChunkFault fault);

/// The fields that a writer stamps; see the layout above.
struct Stamp {
  std::uint64_t writer_id = 0;
  std::uint64_t sequence = 0;
  std::int64_t source_ns = 0;
  std::int64_t expires_ns = 0;
};

struct PartPlace {
  std::uint32_t offset = 0;
  std::uint32_t bytes = 0;
};

/// The offsets of a message's parts in a chunk.
struct ChunkPlan {
  std::size_t small_offset = 0;
  std::size_t parts = 0;
  std::array<std::size_t, msgs::kMostParts> part_offsets{};
  std::size_t bytes = 0;  ///< Size of the whole chunk. Not checked: a chunk has at most 4 GiB.
};
/// `spare` is the number of bytes left free behind the small body, so that a longer one fits too.
[[nodiscard]] ChunkPlan plan_chunk(std::size_t small_bytes, const msgs::PartList& parts, std::size_t spare = 0);

[[nodiscard]] constexpr std::size_t small_offset_of(std::size_t parts) { return kHeadBytes + parts * kPlaceBytes; }

/// Writes head and places. Preconditions: the chunk holds small_offset_of(places.size()) bytes.
void write_head(std::uint8_t* chunk, const Stamp& stamp, std::uint32_t small_bytes, std::span<const PartPlace> places);

/// A chunk whose sizes and offsets have been checked.
struct ChunkView {
  Stamp stamp;
  ByteView small;
  std::size_t parts = 0;
  std::array<PartPlace, msgs::kMostParts> places;
};
/// Reads the head of a chunk. The bytes are hostile, and another process may change them meanwhile, so each field is
/// read once.
[[nodiscard]] Result<ChunkView, ChunkFault> read_chunk(ByteView chunk);

}  // namespace nacelle::transport_iceoryx
