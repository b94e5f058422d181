// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>

#include "nacelle/base/bytes.hpp"

namespace nacelle {

/// Bytes of a stream that have come and have not been used yet, in one piece.
///
/// Threads: one at a time. Allocates: 4 KiB at once, then until it has the size of the longest piece that waited; never more
/// than `longest`.
class ReceiveBuffer {
 public:
  /// `longest`: what waits at most, since the user refuses longer pieces before they are whole.
  explicit ReceiveBuffer(std::size_t longest) : longest_(longest), buffer_(std::min(kFirst, longest)) {}

  /// Where the next bytes go; never empty as long as what waits is shorter than `longest`. Call filled() with how many came.
  [[nodiscard]] ByteSpan room() {
    if (begin_ == end_) {
      begin_ = end_ = 0;
    } else if (begin_ > 0 && end_ == buffer_.size()) {
      std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    if (end_ == buffer_.size()) buffer_.resize(std::min(buffer_.size() * 2, longest_));
    return ByteSpan{buffer_}.subspan(end_);
  }
  void filled(std::size_t bytes) { end_ += bytes; }
  /// Valid until the next room().
  [[nodiscard]] ByteView waiting() const { return ByteView{buffer_}.subspan(begin_, end_ - begin_); }
  /// Of what waits, the first so many have been used.
  void use(std::size_t bytes) { begin_ += bytes; }
  /// Drops what has come; the memory stays.
  void clear() { begin_ = end_ = 0; }

 private:
  static constexpr std::size_t kFirst = 4096;
  std::size_t longest_;
  Bytes buffer_;
  std::size_t begin_ = 0, end_ = 0;
};

}  // namespace nacelle
