// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/bytes.hpp"

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
