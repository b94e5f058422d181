// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>

#include "lidar/protocol/ld06_frame.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::lidar {

/// Why 47 bytes are not a frame.
enum class Ld06Fault : std::uint8_t {
  ChecksumMismatch,  ///< A byte was lost or changed.
  AngleOutOfRange,   ///< An angle of 360 deg or more: not an LD06.
  ImplausibleSpan    ///< The twelve points span more than the speed allows, as the maker's driver checks it.
};

/// Reads one frame from exactly 47 bytes that begin with the start and size bytes. The device measures `points_per_second`.
[[nodiscard]] Result<Ld06Frame, Ld06Fault> decode_ld06_frame(ByteView frame, unsigned points_per_second = 4500);

/// Finds LD06 frames in a stream of bytes, however it is chopped.
///
/// Threads: one. Allocates: nothing.
class Ld06Decoder {
 public:
  /// LD06 and LD19 measure 4500 points per second, others of the family more.
  explicit Ld06Decoder(unsigned points_per_second = 4500) : points_per_second_(points_per_second) {}

  /// Every byte that was fed is in one place: bytes == 47 * frames + 47 * implausible + skipped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{};          ///< Fed so far.
    std::uint64_t frames{};         ///< Handed to the sink.
    std::uint64_t implausible{};    ///< Whole frames with a right checksum that cannot be true.
    std::uint64_t bad_checksums{};  ///< Frame starts that were rejected; their first byte is in skipped_bytes.
    std::uint64_t skipped_bytes{};
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls `on_frame(const Ld06Frame&, std::size_t bytes_after)` for each frame; bytes_after is the number of
  /// bytes of this chunk after the frame's last byte, from which the caller computes when the frame ended.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_frame) {
    stats_.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t taken = std::min(bytes.size(), ld06_layout::kFrameBytes - pending_);
      std::memcpy(window_.data() + pending_, bytes.data(), taken);
      pending_ += taken;
      bytes = bytes.subspan(taken);
      Ld06Frame frame;
      while (settle(frame)) on_frame(static_cast<const Ld06Frame&>(frame), bytes.size());
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
  // Brings a possible frame start to the front of the window; true when a frame was taken out of it.
  bool settle(Ld06Frame& frame);
  void skip(std::size_t count);

  const unsigned points_per_second_;
  std::array<std::uint8_t, ld06_layout::kFrameBytes> window_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::lidar
