// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "nacelle/base/time.hpp"

namespace nacelle {

/// What a callback can learn about a message beside its fields; the same on every path.
struct MessageInfo {
  std::uint64_t writer_id = 0;  ///< Unique in the container; 0 is no writer.
  std::uint64_t sequence = 0;   ///< Counts from 1 per writer; a gap is a loss.
  MonotonicTime source_time;    ///< When publish() was called.
  MonotonicTime received_time;  ///< When this reader's queue got it; the same instant within a process.
};

inline constexpr MonotonicTime kNeverExpires{Duration::max()};

struct Block;

/// Takes messages back when the last reference goes. Implemented in the runtime, never in a component.
class BlockHome {
 public:
  virtual ~BlockHome() = default;
  /// The count of references is one again: the next user's. Threads: any. Must not throw.
  virtual void reclaim(Block& block) noexcept = 0;
};

/// The envelope of one message: reference count, storage, and the pool it returns to.
///
/// Made and owned by the runtime; a component holds one only through a Loan or a shared_ptr. The message lies behind the
/// envelope (pool) or elsewhere (adopted heap message).
/// Source: the layout that was measured before the design (docs/adr/0003).
struct Block {
  std::atomic<std::uint32_t> references{1};
  BlockHome* home = nullptr;
  void* message = nullptr;
  MessageInfo info;
  MonotonicTime expires = kNeverExpires;  ///< The end of the writer's lifespan.
  // The one shared_ptr of this message, made when the first callback asks for it; its control block lies in the envelope,
  // so that shared_ptr<const T> costs no heap. See share_block().
  std::atomic<std::uint8_t> shared_state{0};
  std::uint32_t via = 0;  ///< The link that brought it from another process (EndpointSpec::via); 0: none.
  std::shared_ptr<const void> shared;
  alignas(std::max_align_t) std::byte shared_control[64];
};

namespace detail {
/// The last counted reference of a message that was shared is gone: the envelope waits for the last shared_ptr to let go.
void last_reference_dropped(Block& block) noexcept;
}  // namespace detail

inline void add_reference(Block& block) { block.references.fetch_add(1, std::memory_order_relaxed); }
inline void drop_reference(Block& block) noexcept {
  // A sole holder needs no locked instruction: no other thread can raise the count.
  if (block.references.load(std::memory_order_acquire) != 1) {
    if (block.references.fetch_sub(1, std::memory_order_acq_rel) != 1) return;
    block.references.store(1, std::memory_order_relaxed);  // for its next use
  }
  if (block.shared_state.load(std::memory_order_relaxed) != 0) [[unlikely]]
    return detail::last_reference_dropped(block);
  block.home->reclaim(block);
}

/// Gives a message back to the store it came from.
class ReturnToStore {
 public:
  ReturnToStore() = default;
  explicit ReturnToStore(Block* block) : block_(block) {}
  void operator()(const void*) const noexcept { drop_reference(*block_); }
  [[nodiscard]] Block* block() const { return block_; }

 private:
  Block* block_ = nullptr;
};

/// A message that is yours alone: a unique_ptr whose deleter knows the message's home (design D4).
///
/// A borrowed one holds an earlier message's values and capacity: set every field. An empty one means that the pool ran dry.
template <typename T>
using Loan = std::unique_ptr<T, ReturnToStore>;

/// The message as a shared_ptr, without allocating. The caller holds a reference for the length of the call and keeps it.
///
/// Defined in the vocabulary library, so that the pointer stays valid when the component that asked for it is unloaded; a
/// control block made in a component would dangle. Components only alias it. Threads: any.
[[nodiscard]] std::shared_ptr<const void> share_block(Block& block);

}  // namespace nacelle
