// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>

#include "nacelle/base/bytes.hpp"

namespace nacelle::transport_dds {

struct Blob;

/// The bytes of a message as on the wire: an encapsulation header of four bytes, then CDR. The body is aligned to eight
/// bytes in memory, as in the encoding.
///
/// Holds one reference to a pool's memory, which returns to the pool with the last reference. The others are those of
/// Cyclone's history and retransmissions. The memory belongs to the pool and not to an endpoint, so a payload may
/// outlive its reader.
/// Threads: a value like any other; the bytes never change. Allocates: nothing.
class Payload {
 public:
  Payload() = default;
  /// Takes over one reference.
  explicit Payload(Blob* blob) : blob_(blob) {}
  Payload(Payload&& other) noexcept : blob_(std::exchange(other.blob_, nullptr)) {}
  Payload& operator=(Payload&& other) noexcept {
    std::swap(blob_, other.blob_);
    return *this;
  }
  ~Payload();

  explicit operator bool() const { return blob_ != nullptr; }
  /// Returns the bytes; empty without a blob. Received bytes are hostile: the decoder must check them.
  [[nodiscard]] ByteView bytes() const;

 private:
  Blob* blob_ = nullptr;
};

/// Memory for a message to send, from the pool of its type. Fill it, and pass it to Writer::write().
class OutgoingPayload {
 public:
  OutgoingPayload() = default;
  explicit OutgoingPayload(Blob* blob) : blob_(blob) {}
  OutgoingPayload(OutgoingPayload&& other) noexcept : blob_(std::exchange(other.blob_, nullptr)) {}
  OutgoingPayload& operator=(OutgoingPayload&& other) noexcept {
    std::swap(blob_, other.blob_);
    return *this;
  }
  ~OutgoingPayload();

  /// Returns false if there was no memory, the message is too large, or too many are in use already.
  explicit operator bool() const { return blob_ != nullptr; }
  /// Returns the requested number of bytes, uninitialised.
  [[nodiscard]] ByteSpan bytes();
  [[nodiscard]] Blob* release() { return std::exchange(blob_, nullptr); }

 private:
  Blob* blob_ = nullptr;
};

}  // namespace nacelle::transport_dds
