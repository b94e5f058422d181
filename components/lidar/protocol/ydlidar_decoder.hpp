// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "lidar/protocol/sweep.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::lidar {

namespace ydlidar_layout {
// Source: YDLIDAR/YDLidar-SDK, doc/YDLidar-SDK-Communication-Protocol.md (commit 14f2cb1). Little-endian.
//
//   offset  bytes  field
//        0      2  AA 55
//        2      1  bit 0: first packet of a turn; the rest: turns per second * 10, where the model says it
//        3      1  number of samples
//        4      2  angle of the first sample, 1/64 deg, bits 1-15; bit 0 is 1
//        6      2  angle of the last sample, the same
//        8      2  exclusive or of all other words; an intensity byte is a word of its own
//       10   2, 3  samples: [intensity u8,] u16; without intensity distance in 1/4 mm; with it bits 2-15 distance in mm, bits 0-1 the
//                  high bits of the intensity
inline constexpr std::size_t kHeadBytes = 10, kMostSamples = 255, kMostBytes = kHeadBytes + 3 * kMostSamples;
inline constexpr std::uint8_t kFirst = 0xAA, kSecond = 0x55;
inline constexpr unsigned kFullTurn_q6 = 360 * 64;
}  // namespace ydlidar_layout

/// One packet. Angles as the rotor has them: clockwise, not yet corrected.
struct YdlidarPacket {
  ByteView samples;  ///< Valid during the call.
  std::size_t count = 0;
  double first_deg{}, last_deg{};
  bool starts_turn = false;
  double turns_per_second{};      ///< As the device says; 0: it does not.
  std::uint64_t skipped_bytes{};  ///< Since the packet before.
  std::size_t bytes = 0;          ///< Of the whole packet.
};

/// Finds YDLIDAR packets in a stream of bytes, however it is chopped. Threads: one. Allocates: nothing.
class YdlidarDecoder {
 public:
  explicit YdlidarDecoder(bool has_intensities) : sample_bytes_(has_intensities ? 3 : 2) {}

  /// Calls `on_packet(const YdlidarPacket&, std::size_t bytes_after)` for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_packet) {
    stats_.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t taken = std::min(bytes.size(), std::max(wanted(), pending_ + 1) - pending_);
      std::memcpy(window_.data() + pending_, bytes.data(), taken);
      pending_ += taken;
      bytes = bytes.subspan(taken);
      while (const std::size_t length = settle()) {
        const YdlidarPacket packet = read(length);
        on_packet(packet, bytes.size() + pending_ - length);
        remove(length);
      }
    }
  }
  /// Forgets half a packet: the line was opened again.
  void restart() {
    stats_.skipped_bytes += pending_;
    pending_ = 0;
  }
  [[nodiscard]] const LineStats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  // Bytes that the next decision needs.
  [[nodiscard]] std::size_t wanted() const {
    return pending_ < 4 ? 4 : ydlidar_layout::kHeadBytes + window_[3] * sample_bytes_;
  }
  // Takes what cannot be a packet out of the window's front; returns the length of the packet there, or 0.
  std::size_t settle();
  [[nodiscard]] bool checksum_is_right(std::size_t length) const;
  YdlidarPacket read(std::size_t length);
  void skip(std::size_t count) {
    stats_.skipped_bytes += count;
    remove(count);
  }
  void remove(std::size_t count) {
    pending_ -= count;
    std::memmove(window_.data(), window_.data() + count, pending_);
  }

  const std::size_t sample_bytes_;
  std::array<std::uint8_t, ydlidar_layout::kMostBytes> window_{};
  std::size_t pending_ = 0;
  std::uint64_t skipped_before_ = 0;
  LineStats stats_;
};

/// By how much a triangulating device looks aside at a range. Units: deg, added to the rotor's angle.
/// Source: AngCorrect of the protocol description, atan(21.8 (155.3 - d) / (155.3 d)) with d in mm.
[[nodiscard]] double ydlidar_correction_deg(double range_mm);

}  // namespace nacelle::lidar
