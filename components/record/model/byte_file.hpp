// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include "nacelle/base/bytes.hpp"
#include "record/model/byte_buffer.hpp"

namespace nacelle::record {

/// Where the bytes of a file go, in their order.
class ByteSink {
 public:
  ByteSink() = default;
  ByteSink(const ByteSink&) = delete;
  ByteSink& operator=(const ByteSink&) = delete;
  virtual ~ByteSink() = default;
  /// Errors: false if not all of them could be written.
  [[nodiscard]] virtual bool write(ByteView bytes) = 0;
  /// Writes the buffer's bytes, and leaves an empty buffer: the same one, or another one if the sink keeps its memory until the bytes are written.
  /// Errors: as write().
  [[nodiscard]] virtual bool hand_over(ByteBuffer& buffer) {
    const bool is_written = write(std::as_const(buffer).bytes());
    buffer.clear();
    return is_written;
  }
};

/// Where the bytes of a file come from, in any order.
class ByteSource {
 public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Fills `out` from this offset. Errors: false if not all of it could be read.
  [[nodiscard]] virtual bool read_at(std::uint64_t offset, ByteSpan out) = 0;
};

}  // namespace nacelle::record
