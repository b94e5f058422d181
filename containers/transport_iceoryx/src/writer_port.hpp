// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "iceoryx_posh/runtime/posh_runtime.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::transport_iceoryx {

/// iceoryx's sending port, and the chunks that messages are written into before they are sent.
///
/// As with ReaderPort: memory comes back from any thread, so all calls are under a lock, and the port stays until it is back.
/// Threads: any. Allocates: nothing. Ownership: close() gives it up; it ends itself.
class WriterPort {
 public:
  using Chunk = iox::mepoo::ChunkHeader;
  enum class Loan : std::uint8_t { Ok, TooLarge, NoneLeft };

  /// A chunk in which a message's Buffers lie.
  struct Prepared {
    WriterPort* port = nullptr;
    Chunk* chunk = nullptr;  ///< Null: not in use.
    std::uint8_t* begin = nullptr;
    std::size_t bytes = 0;
    std::size_t uses = 0;
    bool sent = false;
    [[nodiscard]] ReleaseHook hook() {
      return {[](void* self) noexcept { static_cast<Prepared*>(self)->port->back(*static_cast<Prepared*>(self)); },
              this};
    }
  };

  explicit WriterPort(iox::popo::PublisherPortData& data);
  WriterPort(const WriterPort&) = delete;
  WriterPort& operator=(const WriterPort&) = delete;
  void close();

  [[nodiscard]] bool has_readers() const { return port_.hasSubscribers(); }
  /// A chunk to write into; it is sent or given back.
  [[nodiscard]] Loan loan(std::size_t bytes, Chunk*& chunk);
  void send(Chunk& chunk);

  /// A chunk for the Buffers of a message, for `uses` of them; null when there is none to spare.
  [[nodiscard]] Prepared* prepare(std::size_t bytes, std::size_t uses);
  /// The chunk, not yet sent, that this address lies in; null: none.
  [[nodiscard]] Prepared* find(const void* address);
  void send(Prepared& prepared);

 private:
  ~WriterPort();
  void back(Prepared& prepared) noexcept;
  [[nodiscard]] Loan allocate(std::size_t bytes, Chunk*& chunk) NACELLE_REQUIRES(mutex_);

  // Of the eight that iceoryx lends a writer at once; the others are for messages that are copied, and one is in the making.
  static constexpr std::size_t kMostPrepared = 4;

  mutable Mutex mutex_;
  iox::PublisherPortUserType port_;
  std::array<Prepared, kMostPrepared> prepared_ NACELLE_GUARDED_BY(mutex_);
  std::size_t in_use_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool closed_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::transport_iceoryx
