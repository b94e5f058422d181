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

/// iceoryx's receiving port, and the chunks that messages of this process still read.
///
/// iceoryx's port is for one thread at a time, but a chunk comes back from whichever thread drops the last use of its message: all
/// calls are under a lock. The daemon takes a port's chunks away when it is destroyed, so the port stays until the last is back.
/// Threads: any. Allocates: when it is made. Ownership: close() gives it up; it ends itself.
class ReaderPort {
 public:
  using Chunk = const iox::mepoo::ChunkHeader;

  /// A chunk that a message's Buffers lie in.
  class Hold {
   public:
    /// For one Buffer each. Preconditions: announced in hold().
    [[nodiscard]] ReleaseHook hook() { return {&Hold::release, this}; }
    void drop(std::size_t uses) noexcept;

   private:
    friend class ReaderPort;
    static void release(void* self) noexcept { static_cast<Hold*>(self)->drop(1); }
    ReaderPort* port_ = nullptr;
    Chunk* chunk_ = nullptr;
    std::atomic<std::size_t> uses_{0};
  };

  /// `most_held` chunks may be held at once.
  ReaderPort(iox::popo::SubscriberPortData& data, std::size_t most_held);
  ReaderPort(const ReaderPort&) = delete;
  ReaderPort& operator=(const ReaderPort&) = delete;
  void close();

  /// The oldest chunk that waits; null: none.
  [[nodiscard]] Chunk* take();
  void give_back(Chunk& chunk);
  /// Keeps a taken chunk until all `uses` of it are dropped; null when too many are held already.
  [[nodiscard]] Hold* hold(Chunk& chunk, std::size_t uses);
  /// True if messages were overwritten since the last call, because the queue was full.
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

/// The bytes of a chunk as far as its own sizes agree with each other; empty when they do not.
[[nodiscard]] ByteView payload_of(const iox::mepoo::ChunkHeader& chunk);

}  // namespace nacelle::transport_iceoryx
