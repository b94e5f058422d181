// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/mutex.hpp"
#include "transport_dds/port/cyclone.hpp"

namespace nacelle::transport_dds {

class BlobPool;
/// The number of payloads of one writer in use: borrowed, in its history, or waiting for retransmission.
using OutCount = std::atomic<std::uint32_t>;

/// Cyclone's view of a message (its serdata), with the CDR bytes behind it in the same piece of memory.
///
/// Cyclone counts the references. When the last one is released, the blob returns to its pool, or to the heap if it has
/// none (keys: all keys of these types are equal). Freeing does not use `type`, whose references Cyclone does not
/// count, so a blob may outlive its topic.
struct Blob : ddsi_serdata {
  BlobPool* pool = nullptr;
  std::shared_ptr<OutCount> out;  ///< Null for received messages.
  std::uint32_t size = 0;         ///< Bytes in use.
  std::uint32_t capacity = 0;

  [[nodiscard]] std::uint8_t* data() {
    // The encapsulation header begins four bytes after an aligned address, so that the body is aligned to eight.
    return reinterpret_cast<std::uint8_t*>(this + 1) + 4;
  }
  [[nodiscard]] ByteView bytes() const { return {const_cast<Blob*>(this)->data(), size}; }
};
static_assert(alignof(Blob) == 8 && sizeof(Blob) % 8 == 0);

struct BlobLimits {
  std::size_t most_bytes = std::size_t{64} << 20U;       ///< Of one message.
  std::size_t most_bytes_out = std::size_t{256} << 20U;  ///< Of all messages of one type in use.
};

/// The memory of the messages of one type: released blobs are reused.
///
/// Keeps about twice the longest recent message for the next ones, and returns the rest to the heap. When a limit is
/// reached or there is no memory, the message is refused and counted. Ownership: its sertype, and each blob in use.
/// Threads: any.
class BlobPool final {
 public:
  /// Returns a pool whose first user is the caller. Null: no memory.
  [[nodiscard]] static BlobPool* make(const BlobLimits& limits) noexcept;
  void drop_user() noexcept;

  /// Returns a blob with one reference, the caller's; null: refused.
  [[nodiscard]] Blob* borrow(const ddsi_sertype& type, std::size_t bytes) noexcept;
  /// Takes back a blob whose last reference was released.
  void take_back(Blob& blob) noexcept;

  [[nodiscard]] std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::size_t bytes_out() const { return bytes_out_.load(std::memory_order_relaxed); }
  /// Returns the number of bytes that are kept for reuse.
  [[nodiscard]] std::size_t bytes_kept() const;

 private:
  explicit BlobPool(const BlobLimits& limits) : limits_(limits) {}
  ~BlobPool();
  [[nodiscard]] Blob* take_kept(std::size_t bytes) noexcept;
  [[nodiscard]] Blob* remove_kept(std::size_t place) noexcept NACELLE_REQUIRES(mutex_);

  static constexpr std::size_t kMostKept = 16;
  const BlobLimits limits_;
  std::atomic<std::size_t> users_{1};
  std::atomic<std::size_t> bytes_out_{0};
  std::atomic<std::uint64_t> refused_{0};
  mutable Mutex mutex_;
  std::array<Blob*, kMostKept> kept_ NACELLE_GUARDED_BY(mutex_){};
  std::size_t kept_count_ NACELLE_GUARDED_BY(mutex_) = 0, kept_bytes_ NACELLE_GUARDED_BY(mutex_) = 0;
  std::size_t recent_ NACELLE_GUARDED_BY(mutex_) = 0;  // the longest recent message
};

/// Returns a key of these types: no bytes, no pool. Null: no memory.
[[nodiscard]] Blob* make_key(const ddsi_sertype* type, const ddsi_serdata_ops& ops) noexcept;
/// Frees a blob whose last reference was released.
void free_blob(Blob& blob) noexcept;

}  // namespace nacelle::transport_dds
