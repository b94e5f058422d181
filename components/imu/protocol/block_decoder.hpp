// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::imu {

namespace block_layout {
// What a polled device's stream is made of (nacelle/io/register_stream.hpp): an answer of the device with its tag.
//
//   offset  bytes  field
//        0      1  tag      which registers; with 0x80: a FIFO was full, what it held is lost
//        1      2  length   little-endian
//        3      n  bytes
inline constexpr std::size_t kHeaderBytes = 3, kMostBytes = 4096;
inline constexpr std::uint8_t kOverflowBit = 0x80;
}  // namespace block_layout

/// Finds the blocks in a stream, however it is chopped.
///
/// Threads: one. Allocates: nothing but at construction.
class BlockDecoder {
 public:
  /// Every byte that was fed is in one place: bytes == 3 * blocks + payload_bytes + skipped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{}, blocks{}, payload_bytes{};
    std::uint64_t skipped_bytes{};  ///< Headers of blocks that are too long, byte by byte; torn blocks.
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  BlockDecoder() : window_(block_layout::kHeaderBytes + block_layout::kMostBytes) {}

  /// Calls `on_block(std::uint8_t tag, ByteView payload)` for each block.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_block) {
    stats_.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t taken = std::min(bytes.size(), wanted() - pending_);
      std::copy_n(bytes.begin(), taken, window_.begin() + static_cast<std::ptrdiff_t>(pending_));
      pending_ += taken;
      bytes = bytes.subspan(taken);
      skip_what_is_no_header();
      if (pending_ < block_layout::kHeaderBytes || pending_ < wanted()) continue;
      ++stats_.blocks;
      stats_.payload_bytes += length();
      pending_ = 0;
      on_block(window_[0], ByteView{window_}.subspan(block_layout::kHeaderBytes, length()));
    }
  }

  /// Forgets half a block: the stream began anew.
  void restart() {
    stats_.skipped_bytes += pending_;
    pending_ = 0;
  }
  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  [[nodiscard]] std::size_t length() const { return load_le16(window_.data() + 1); }
  [[nodiscard]] std::size_t wanted() const {
    return pending_ < block_layout::kHeaderBytes ? block_layout::kHeaderBytes : block_layout::kHeaderBytes + length();
  }
  void skip_what_is_no_header() {
    while (pending_ == block_layout::kHeaderBytes && length() > block_layout::kMostBytes) {
      std::copy_n(window_.begin() + 1, 2, window_.begin());
      pending_ = 2;
      ++stats_.skipped_bytes;
    }
  }

  Bytes window_;
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::imu
