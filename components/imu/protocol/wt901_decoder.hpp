// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>

#include "imu/protocol/wt901_frame.hpp"

namespace nacelle::imu {

/// Finds WT901 frames in a stream of bytes, however it is chopped.
///
/// Threads: one. Allocates: nothing.
class Wt901Decoder {
 public:
  /// Every byte that was fed is in one place: bytes == 11 * frames + skipped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{};          ///< Fed so far.
    std::uint64_t frames{};         ///< Handed to the sink.
    std::uint64_t bad_checksums{};  ///< Frame starts that were rejected; their first byte is in skipped_bytes.
    std::uint64_t skipped_bytes{};
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls `on_frame(const Wt901Frame&, std::size_t bytes_after)` for each frame; bytes_after is how much of this chunk
  /// came after the frame's last byte.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_frame) {
    stats_.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t taken = std::min(bytes.size(), wt901_layout::kFrameBytes - pending_);
      std::memcpy(window_.data() + pending_, bytes.data(), taken);
      pending_ += taken;
      bytes = bytes.subspan(taken);
      Wt901Frame frame;
      while (settle(frame)) on_frame(static_cast<const Wt901Frame&>(frame), bytes.size());
    }
  }

  /// Forgets half a frame: the line was opened again.
  void restart() {
    stats_.skipped_bytes += pending_;
    pending_ = 0;
  }
  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  bool settle(Wt901Frame& frame);
  void skip(std::size_t count);

  std::array<std::uint8_t, wt901_layout::kFrameBytes> window_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::imu
