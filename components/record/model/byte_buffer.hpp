// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>

#include "nacelle/base/bytes.hpp"

namespace nacelle::record {

/// Bytes that are filled from the start, emptied and filled again. The memory stays, and unlike that of an emptied vector it is not set to zero before it
/// is filled again.
///
/// Threads: one. Allocates: where it grows beyond what it ever had.
class ByteBuffer {
 public:
  ByteBuffer() = default;
  explicit ByteBuffer(std::size_t capacity) : memory_(capacity) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return memory_.size(); }
  [[nodiscard]] ByteView bytes() const { return ByteView{memory_.data(), size_}; }
  [[nodiscard]] ByteSpan bytes() { return ByteSpan{memory_.data(), size_}; }
  void clear() { size_ = 0; }
  /// Returns room for so many bytes more, at the end; their content is what was there before. Earlier spans are invalid then.
  [[nodiscard]] ByteSpan extend(std::size_t more) {
    if (memory_.size() - size_ < more) memory_.resize(std::max(size_ + more, memory_.size() + memory_.size() / 2));
    const ByteSpan room{memory_.data() + size_, more};
    size_ += more;
    return room;
  }
  void append(ByteView more) {
    const ByteSpan room = extend(more.size());
    if (!more.empty()) std::memcpy(room.data(), more.data(), more.size());
  }

 private:
  Bytes memory_;
  std::size_t size_ = 0;
};

}  // namespace nacelle::record
