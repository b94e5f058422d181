// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>

#include "nacelle/base/bytes.hpp"

namespace nacelle::transport_dds {

struct Blob;

/// The bytes of a message as they are on the wire: the encapsulation header of four bytes first, then CDR. The body is
/// aligned to eight bytes in memory, as it is in the encoding.
///
/// One holder's share of a pool's memory, which goes back with the last one: the other holders are Cyclone's history
/// and retransmissions. The memory belongs to the pool and not to an endpoint, so a payload stays valid after its
/// reader.
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
  /// Empty without a blob. From a peer: any bytes at all, of any length; whoever decodes them checks them.
  [[nodiscard]] ByteView bytes() const;

 private:
  Blob* blob_ = nullptr;
};

/// Memory for a message that will be sent, from the pool of its type. To be filled, and handed to Writer::write().
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

  /// False: there was no memory, or the message is too large, or too many wait already.
  explicit operator bool() const { return blob_ != nullptr; }
  /// As many bytes as were asked for; they hold anything.
  [[nodiscard]] ByteSpan bytes();
  [[nodiscard]] Blob* release() { return std::exchange(blob_, nullptr); }

 private:
  Blob* blob_ = nullptr;
};

}  // namespace nacelle::transport_dds
