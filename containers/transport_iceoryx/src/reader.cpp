// SPDX-License-Identifier: Apache-2.0
#include "reader.hpp"

#include <algorithm>
#include <array>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::transport_iceoryx {

void StreamReader::deliver() {
  const LockGuard lock(mutex_);
  if (closed_) return;
  while (ReaderPort::Chunk* const chunk = port_.take()) deliver(*chunk);
  if (port_.was_overrun()) totals_.overruns.fetch_add(1, std::memory_order_relaxed);
}

void StreamReader::close() {
  const LockGuard lock(mutex_);
  if (closed_) return;
  closed_ = true;
  port_.close();
}

void StreamReader::deliver(ReaderPort::Chunk& chunk) {
  const ByteView bytes = payload_of(chunk);
  const auto view = read_chunk(bytes);
  if (view) return read(*view, chunk, bytes.data());
  port_.give_back(chunk);
  note_broken(explain(view.error()));
}

void StreamReader::read(const ChunkView& view, ReaderPort::Chunk& chunk, const std::uint8_t* bytes) {
  Block* const block = sink_.borrow();
  if (block == nullptr) return port_.give_back(chunk);
  std::array<msgs::LentPart, msgs::kMostParts> parts;
  // One use more than parts: this call's own, so that the chunk stays while it is read.
  ReaderPort::Hold* const hold = view.parts != 0 && sink_.may_lend() ? port_.hold(chunk, view.parts + 1) : nullptr;
  for (std::size_t i = 0; i < view.parts; ++i) {
    // This memory is never written to: lent memory is const for its readers, and the sink decides whether one may take
    // ownership.
    auto* const memory = const_cast<std::uint8_t*>(bytes) + view.places[i].offset;
    parts[i] = {memory, view.places[i].bytes, hold == nullptr ? ReleaseHook{} : hold->hook()};
  }
  const auto read = msgs::decode_apart(type_, view.small, {parts.data(), view.parts}, block->message);
  // The chunk goes back with its last use: at once, so that the writer may use it for the next message, or when the message goes.
  if (hold == nullptr) {
    port_.give_back(chunk);
    for (std::size_t i = 0; i < view.parts; ++i)
      totals_.bytes_copied.fetch_add(parts[i].bytes, std::memory_order_relaxed);
  } else {
    const auto unused = static_cast<std::size_t>(
        std::count_if(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(view.parts),
                      [](const msgs::LentPart& part) { return part.hook.release != nullptr; }));
    totals_.lent.fetch_add(view.parts - unused, std::memory_order_relaxed);
    hold->drop(unused + 1);
  }
  if (!read) {
    drop_reference(*block);
    return note_broken(msgs::explain(read.error()));
  }
  block->expires = MonotonicTime{Duration{view.stamp.expires_ns}};
  sink_.deliver(*block, {view.stamp.writer_id, view.stamp.sequence, MonotonicTime{Duration{view.stamp.source_ns}}, {}});
}

void StreamReader::note_broken(const char* why) {
  totals_.broken.fetch_add(1, std::memory_order_relaxed);
  sink_.note_broken(why);
}

}  // namespace nacelle::transport_iceoryx
