// SPDX-License-Identifier: Apache-2.0
#include "reader.hpp"

#include <algorithm>
#include <array>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::transport_iceoryx {

void StreamReader::deliver() {
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  while (ReaderPort::Chunk* const chunk = port_.take()) deliver(*chunk);
  if (port_.was_overrun()) totals_.overruns.fetch_add(1, std::memory_order_relaxed);
}

void StreamReader::close() {
  const std::lock_guard lock(mutex_);
  if (closed_) return;
  closed_ = true;
  port_.close();
}

void StreamReader::deliver(ReaderPort::Chunk& chunk) {
  const ByteView bytes = payload_of(chunk);
  const auto view = read_chunk(bytes);
  bool held = false;
  if (view) {
    held = read(*view, chunk, bytes.data());
  } else {
    note_broken(explain(view.error()));
  }
  if (!held) port_.give_back(chunk);
}

bool StreamReader::read(const ChunkView& view, ReaderPort::Chunk& chunk, const std::uint8_t* bytes) {
  Block* const block = sink_.borrow();
  if (block == nullptr) return false;
  std::array<msgs::LentPart, msgs::kMostParts> parts;
  // One use more than parts: this call's own, so that the chunk stays while it is read.
  ReaderPort::Hold* const hold = view.parts != 0 && sink_.may_lend() ? port_.hold(chunk, view.parts + 1) : nullptr;
  std::uint64_t long_bytes = 0;
  for (std::size_t i = 0; i < view.parts; ++i) {
    // Nobody writes there: what a message was lent is const to its readers, and the sink says if one may take it for itself.
    auto* const memory = const_cast<std::uint8_t*>(bytes) + view.places[i].offset;
    parts[i] = {memory, view.places[i].bytes, hold == nullptr ? ReleaseHook{} : hold->hook()};
    long_bytes += view.places[i].bytes;
  }
  const auto read = msgs::decode_apart(type_, view.small, {parts.data(), view.parts}, block->message);
  if (hold != nullptr) {
    const auto unused = std::count_if(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(view.parts),
                                      [](const msgs::LentPart& part) { return part.hook.release != nullptr; });
    totals_.lent.fetch_add(view.parts - static_cast<std::size_t>(unused), std::memory_order_relaxed);
    // The chunk goes back with the last use: now, or when the message goes.
    hold->drop(static_cast<std::size_t>(unused) + 1);
  } else if (long_bytes != 0) {
    totals_.bytes_copied.fetch_add(long_bytes, std::memory_order_relaxed);
  }
  if (!read) {
    drop_reference(*block);
    note_broken(msgs::explain(read.error()));
    return hold != nullptr;
  }
  sink_.deliver(*block, {view.stamp.writer_id, view.stamp.sequence, MonotonicTime{Duration{view.stamp.source_ns}}, {}});
  return hold != nullptr;
}

void StreamReader::note_broken(const char* why) {
  totals_.broken.fetch_add(1, std::memory_order_relaxed);
  sink_.note_broken(why);
}

}  // namespace nacelle::transport_iceoryx
