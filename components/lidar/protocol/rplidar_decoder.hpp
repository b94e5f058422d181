// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <utility>

#include "lidar/protocol/rplidar_frames.hpp"

namespace nacelle::lidar {

/// One answer, or one packet of an endless one.
struct RplidarPacket {
  RplidarAnswer type = RplidarAnswer::None;
  ByteView bytes;                 ///< Valid during the call.
  std::uint64_t skipped_bytes{};  ///< Since the packet before.
  bool is_first = true;           ///< Of its answer: there is none before.
  [[nodiscard]] bool follows() const { return skipped_bytes == 0 && !is_first; }
};

/// Finds the answer that is expected, and then the packets of an endless one, in a stream of bytes, however it is chopped.
///
/// Only the expected descriptor counts: what is left of an earlier stream cannot be taken for an answer. A node has no checksum;
/// three in a row whose check bits fit and whose angles follow each other are believed, and from then on each that continues them.
/// Threads: one. Allocates: nothing.
class RplidarDecoder {
 public:
  /// From now on only an answer of this type is one; None: nothing is.
  void expect(RplidarAnswer type);

  /// Calls `on_packet(const RplidarPacket&, std::size_t bytes_after)` for each; it may call expect().
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_packet) {
    stats_.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t taken = std::min(bytes.size(), std::max(wanted(), pending_ + 1) - pending_);
      std::memcpy(window_.data() + pending_, bytes.data(), taken);
      pending_ += taken;
      bytes = bytes.subspan(taken);
      while (const std::size_t length = settle()) {
        // The packet leaves the window before the call, so that the sink may change what is expected.
        std::memcpy(packet_.data(), window_.data(), length);
        remove(length);
        const RplidarPacket packet{expected_,
                                   {packet_.data(), length},
                                   stats_.skipped_bytes - std::exchange(skipped_before_, stats_.skipped_bytes),
                                   std::exchange(is_first_, false)};
        if (!is_stream(expected_)) expected_ = RplidarAnswer::None;
        on_packet(packet, bytes.size() + pending_);
      }
    }
  }

  /// Forgets half a packet and what was expected: the line was opened again.
  void restart() { expect(RplidarAnswer::None); }
  [[nodiscard]] const LineStats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }
  [[nodiscard]] RplidarAnswer expected() const { return expected_; }

 private:
  static constexpr std::size_t kNodesToBelieve = 3;

  // Bytes that the next decision needs.
  [[nodiscard]] std::size_t wanted() const;
  // Takes what cannot be a packet out of the window's front; returns the length of the packet there, or 0.
  std::size_t settle();
  std::size_t settle_descriptor();
  std::size_t settle_node();
  std::size_t settle_capsule();
  [[nodiscard]] bool nodes_follow() const;
  void skip(std::size_t count);
  void remove(std::size_t count);

  std::array<std::uint8_t, rplidar_layout::kMostPacketBytes> window_{}, packet_{};
  std::size_t pending_ = 0;
  RplidarAnswer expected_ = RplidarAnswer::None;
  std::size_t length_ = 0;            ///< Of the packets, once the descriptor came.
  bool believes_ = false;             ///< The nodes are aligned.
  unsigned last_angle_q6_ = 0;        ///< Of the last node.
  std::uint64_t skipped_before_ = 0;  ///< Until the last packet.
  bool is_first_ = true;
  LineStats stats_;
};

}  // namespace nacelle::lidar
