// SPDX-License-Identifier: Apache-2.0
#include "writer.hpp"

#include <cstring>
#include <limits>

#include "nacelle/base/log.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::transport_iceoryx {
namespace {

// Texts of a prepared message may become that much longer than the last one's.
constexpr std::size_t kSpareBytes = 256;

bool is_own_field(const msgs::MessageType& type, const msgs::Step* step) {
  return step >= type.steps.data() && step < type.steps.data() + type.steps.size();
}

// A reader of this process may still read a sent chunk that its next user overwrites.
bool has_other_holders(const Block& block) {
  return block.references.load(std::memory_order_acquire) != 1 ||
         block.shared_state.load(std::memory_order_acquire) != 0;
}

}  // namespace

CarrierWriter::Sent StreamWriter::send(const Block& block) {
  if (!daemon_.is_alive()) return Sent::Dead;
  msgs::PartList parts;
  const std::size_t small_bytes = msgs::encoded_size_apart(type_, block.message, parts);
  if (small_bytes > std::numeric_limits<std::uint32_t>::max()) return refuse("it is larger than 4 GiB", small_bytes);
  const Stamp stamp{block.info.writer_id, block.info.sequence, block.info.source_time.nanoseconds(),
                    block.expires.nanoseconds()};
  if (parts.count == 0) return send_copy(block, stamp, small_bytes, parts);
  remember(small_bytes, parts);
  if (send_in_place(block, stamp, small_bytes, parts)) return Sent::Yes;
  return send_copy(block, stamp, small_bytes, parts);
}

bool StreamWriter::send_in_place(const Block& block, const Stamp& stamp, std::size_t small_bytes,
                                 const msgs::PartList& parts) {
  WriterPort::Prepared* const prepared = port_.find(parts.parts[0].numbers);
  if (prepared == nullptr || has_other_holders(block)) return false;
  const std::size_t small_offset = small_offset_of(parts.count);
  std::array<PartPlace, msgs::kMostParts> places;
  for (std::size_t i = 0; i < parts.count; ++i) {
    const auto* const numbers = static_cast<const std::uint8_t*>(parts.parts[i].numbers);
    if (numbers < prepared->begin + small_offset + small_bytes || numbers > prepared->begin + prepared->bytes)
      return false;
    const auto offset = static_cast<std::size_t>(numbers - prepared->begin);
    if (parts.parts[i].bytes > prepared->bytes - offset) return false;
    places[i] = {static_cast<std::uint32_t>(offset), static_cast<std::uint32_t>(parts.parts[i].bytes)};
  }
  write_head(prepared->begin, stamp, static_cast<std::uint32_t>(small_bytes), {places.data(), parts.count});
  msgs::encode_apart(type_, block.message, prepared->begin + small_offset);
  port_.send(*prepared);
  return true;
}

CarrierWriter::Sent StreamWriter::send_copy(const Block& block, const Stamp& stamp, std::size_t small_bytes,
                                            const msgs::PartList& parts) {
  const ChunkPlan plan = plan_chunk(small_bytes, parts);
  WriterPort::Chunk* chunk = nullptr;
  switch (port_.loan(plan.bytes, chunk)) {
    case WriterPort::Loan::TooLarge: return refuse("it is larger than the daemon's largest chunk", plan.bytes);
    case WriterPort::Loan::NoneLeft: return refuse("the daemon has no chunk left of that size", plan.bytes);
    case WriterPort::Loan::Ok: break;
  }
  auto* const begin = static_cast<std::uint8_t*>(chunk->userPayload());
  std::array<PartPlace, msgs::kMostParts> places;
  std::uint64_t copied = small_bytes;
  for (std::size_t i = 0; i < parts.count; ++i) {
    const msgs::Part& part = parts.parts[i];
    places[i] = {static_cast<std::uint32_t>(plan.part_offsets[i]), static_cast<std::uint32_t>(part.bytes)};
    std::memcpy(begin + plan.part_offsets[i], part.numbers, part.bytes);
    copied += part.bytes;
  }
  write_head(begin, stamp, static_cast<std::uint32_t>(small_bytes), {places.data(), parts.count});
  msgs::encode_apart(type_, block.message, begin + plan.small_offset);
  port_.send(*chunk);
  // One thread writes: no locked instruction.
  bytes_copied_.store(bytes_copied_.load(std::memory_order_relaxed) + copied, std::memory_order_relaxed);
  return Sent::Yes;
}

void StreamWriter::remember(std::size_t small_bytes, const msgs::PartList& parts) {
  auto last = last_.lock();
  last->small_bytes = small_bytes;
  last->parts.count = 0;
  for (std::size_t i = 0; i < parts.count; ++i) {
    // Only what lies in the message itself can be found again in the next one; elements of its sequences are copied.
    if (is_own_field(type_, parts.parts[i].step)) last->parts.parts[last->parts.count++] = parts.parts[i];
  }
}

void StreamWriter::prepare(Block& block) {
  const Layout last = [this] {
    auto locked = last_.lock();
    return *locked;
  }();
  const msgs::PartList& parts = last.parts;
  if (parts.count == 0 || !is_connected()) return;
  const ChunkPlan plan = plan_chunk(last.small_bytes, parts, kSpareBytes);
  WriterPort::Prepared* const prepared = port_.prepare(plan.bytes, parts.count);
  if (prepared == nullptr) return;
  for (std::size_t i = 0; i < parts.count; ++i) {
    const msgs::Step& step = *parts.parts[i].step;
    const std::size_t elements = parts.parts[i].bytes / step.width;
    step.sequence->adopt(static_cast<std::uint8_t*>(block.message) + step.offset,
                         prepared->begin + plan.part_offsets[i], elements, elements, prepared->hook());
  }
}

CarrierWriter::Sent StreamWriter::refuse(const char* why, std::size_t bytes) {
  if (!refused_) {
    Logger("transport_iceoryx")
        .warn("{}: a message of {} bytes cannot go through shared memory: {}", name_, bytes, why);
  }
  refused_ = true;
  return Sent::Refused;
}

}  // namespace nacelle::transport_iceoryx
