// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "iceoryx_posh/runtime/posh_runtime.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::transport_iceoryx {

/// A subscriber port of iceoryx, and the chunks that messages of this process still read in place.
///
/// iceoryx's port supports one thread at a time, but a chunk is given back by the thread that releases its message, so
/// all calls take a lock. Destroying the port would free its chunks, so it is destroyed only when all of them are back.
/// Threads: any. Allocates: in the constructor. Ownership: make it with `new`; after close() it deletes itself.
class ReaderPort {
 public:
  using Chunk = const iox::mepoo::ChunkHeader;

  /// A chunk that contains Buffers of a message.
  class Hold {
   public:
    /// Returns the hook that drops one use, for one Buffer. Preconditions: the use was counted in hold().
    [[nodiscard]] ReleaseHook hook() { return {&Hold::release, this}; }
    void drop(std::size_t uses) noexcept;

   private:
    friend class ReaderPort;
    static void release(void* self) noexcept { static_cast<Hold*>(self)->drop(1); }
    ReaderPort* port_ = nullptr;
    Chunk* chunk_ = nullptr;
    std::atomic<std::size_t> uses_{0};
  };

  /// `most_held` is the number of chunks that may be held at the same time.
  ReaderPort(iox::popo::SubscriberPortData& data, std::size_t most_held);
  ReaderPort(const ReaderPort&) = delete;
  ReaderPort& operator=(const ReaderPort&) = delete;
  void close();

  /// Takes the oldest waiting chunk; null: none.
  [[nodiscard]] Chunk* take();
  void give_back(Chunk& chunk);
  /// Keeps a taken chunk until all `uses` of it are dropped. Returns null if too many chunks are held already.
  [[nodiscard]] Hold* hold(Chunk& chunk, std::size_t uses);
  /// Returns true if messages were dropped since the last call, because the queue was full.
  [[nodiscard]] bool was_overrun();
  void notify(iox::popo::ConditionVariableData& condition, std::size_t index);

 private:
  ~ReaderPort();
  void back(Hold& hold) noexcept;

  mutable Mutex mutex_;
  iox::SubscriberPortUserType port_ NACELLE_GUARDED_BY(mutex_);
  std::unique_ptr<Hold[]> holds_ NACELLE_GUARDED_BY(mutex_);
  std::vector<Hold*> free_ NACELLE_GUARDED_BY(mutex_);
  std::size_t held_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool closed_ NACELLE_GUARDED_BY(mutex_) = false;
};

/// Returns the payload of a chunk; empty if the sizes in its header contradict each other.
[[nodiscard]] ByteView payload_of(const iox::mepoo::ChunkHeader& chunk);

}  // namespace nacelle::transport_iceoryx
