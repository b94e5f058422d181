// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "iceoryx_posh/runtime/posh_runtime.hpp"
#include "nacelle/base/buffer.hpp"
#include "nacelle/base/mutex.hpp"

namespace nacelle::transport_iceoryx {

/// A publisher port of iceoryx, and the chunks that messages are written into before they are sent.
///
/// As with ReaderPort, chunks are given back from any thread, so all calls take a lock, and the port is destroyed only
/// when all chunks are back.
/// Threads: any. Allocates: nothing. Ownership: make it with `new`; after close() it deletes itself.
class WriterPort {
 public:
  using Chunk = iox::mepoo::ChunkHeader;
  enum class Loan : std::uint8_t { Ok, TooLarge, NoneLeft };

  /// A chunk that contains Buffers of a message.
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
  /// Borrows a chunk to write into; the caller must send() it.
  [[nodiscard]] Loan loan(std::size_t bytes, Chunk*& chunk);
  void send(Chunk& chunk);

  /// Borrows a chunk for `uses` Buffers of a message. Returns null if kMostPrepared are in use, or the daemon has none.
  [[nodiscard]] Prepared* prepare(std::size_t bytes, std::size_t uses);
  /// Returns the prepared chunk that contains this address and has not been sent; null: none.
  [[nodiscard]] Prepared* find(const void* address);
  void send(Prepared& prepared);

 private:
  ~WriterPort();
  void back(Prepared& prepared) noexcept;
  [[nodiscard]] Loan allocate(std::size_t bytes, Chunk*& chunk) NACELLE_REQUIRES(mutex_);

  // iceoryx lends a writer at most eight chunks at a time. The others remain for messages that send() copies.
  static constexpr std::size_t kMostPrepared = 4;

  mutable Mutex mutex_;
  iox::PublisherPortUserType port_;
  std::array<Prepared, kMostPrepared> prepared_ NACELLE_GUARDED_BY(mutex_);
  std::size_t in_use_ NACELLE_GUARDED_BY(mutex_) = 0;
  bool closed_ NACELLE_GUARDED_BY(mutex_) = false;
};

}  // namespace nacelle::transport_iceoryx
