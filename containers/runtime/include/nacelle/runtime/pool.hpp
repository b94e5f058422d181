// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

#include "nacelle/host/message.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::runtime {

/// The envelopes and messages of one writer.
///
/// borrow() returns recycled messages, which keep their values and capacity; foreign Buffers are returned at the last
/// release. reserve() allocates what the stream's queues can hold. Beyond that, messages are allocated on demand and
/// counted, or, with a limit, one spare message is lent that must not be published.
///
/// Threads:   borrow() and adopt() from the writer's thread; reclaim() from any. A reclaimer's push is its last access,
/// so the owner may delete the pool as soon as every envelope is back (all_home()).
/// Allocates: in borrow() and adopt() when nothing is free.
class MessagePool final : public BlockHome {
 public:
  explicit MessagePool(const msgs::MessageType& type) : type_(type) {}
  ~MessagePool() override;
  MessagePool(const MessagePool&) = delete;
  MessagePool& operator=(const MessagePool&) = delete;

  /// Returns a block with one reference, the caller's. Beyond the limit it returns the spare block, or null if that is
  /// in use too.
  [[nodiscard]] Block* borrow();
  /// The same, but null beyond the limit.
  [[nodiscard]] Block* borrow_regular();
  /// Returns whether the block is the spare that borrow() lends beyond the limit.
  [[nodiscard]] bool is_spare(const Block& block) const { return &block == spare_; }
  /// Limits the number of messages from now on, and allocates the spare. Threads: the writer's.
  void set_limit(std::size_t messages);
  /// Returns an envelope around a message made with `new`; takes ownership of it.
  [[nodiscard]] Block* adopt(void* message);
  void reclaim(Block& block) noexcept override;
  /// Allocates envelopes up to that number, each with a copy of `like`, so that strings and sequences have their
  /// capacity and filling the queues allocates nothing later. Large Buffers get their memory and no elements
  /// (ReservingCopies), so that their pages count once they are used. Threads: the writer's.
  void reserve(std::size_t envelopes, const void* like);

  /// Copies `like`, the first published message, to the free messages, so that they have its capacity; large Buffers as
  /// in reserve(). Keeps at most `most` free messages and frees the others.
  void warm(const void* like, std::size_t most);

  [[nodiscard]] std::size_t limit() const { return limit_; }
  /// Returns the number of envelopes in use. Threads: the owner's only.
  [[nodiscard]] std::size_t outstanding();
  /// Returns the number of envelopes ever made. Threads: any.
  [[nodiscard]] std::uint64_t made() const { return made_.load(std::memory_order_relaxed); }
  [[nodiscard]] const msgs::MessageType& type() const { return type_; }

 private:
  struct Envelope;
  Envelope* take_free(bool with_message);
  Envelope* make_pooled();
  void dispose(Envelope* envelope);
  void let_go(Envelope& envelope) noexcept;
  void collect();

  const msgs::MessageType& type_;
  std::atomic<Envelope*> returned_{nullptr};  // pushed by any thread, taken as a whole by the owner: no ABA
  Envelope* free_pooled_ = nullptr;
  Envelope* free_bare_ = nullptr;
  std::size_t free_count_ = 0;
  std::size_t pooled_ = 0;
  std::size_t limit_ = ~std::size_t{0};
  Block* spare_ = nullptr;  // not counted in pooled_
  bool spare_is_out_ = false;
  std::size_t disposed_ = 0;
  std::atomic<std::uint64_t> made_{0};
};

}  // namespace nacelle::runtime
