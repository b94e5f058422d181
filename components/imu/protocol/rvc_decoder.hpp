// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "nacelle/base/bytes.hpp"

namespace nacelle::imu {

namespace rvc_layout {
// BNO08x in the mode UART-RVC: 115200 baud, 100 frames a second, one way. Source: BNO080 data sheet, page 21.
//
//   offset  bytes  field     on the wire
//        0      2  start     aa aa
//        2      1  index     one more with each frame
//        3      6  angles    yaw, pitch, roll: int16, little-endian, 0.01 degrees
//        9      6  accel     x y z: int16, little-endian, 0.001 g
//       15      3  reserved  motion intent and request in newer parts
//       18      1  checksum  sum of bytes 2 to 17, modulo 256
inline constexpr std::size_t kIndex = 2, kAngles = 3, kAcceleration = 9, kChecksum = 18, kFrameBytes = 19;
inline constexpr std::uint8_t kStartByte = 0xAA;
}  // namespace rvc_layout

/// One frame, in the device's units.
struct RvcFrame {
  std::uint8_t index{};
  std::array<std::int16_t, 3> angles_cdeg{};  ///< Yaw, pitch, roll.
  std::array<std::int16_t, 3> acceleration_mg{};
  friend bool operator==(const RvcFrame&, const RvcFrame&) = default;
};

/// Finds RVC frames in a stream of bytes, however it is chopped.
///
/// Threads: one. Allocates: nothing.
class RvcDecoder {
 public:
  /// Every byte that was fed is in one place: bytes == 19 * frames + skipped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{};
    std::uint64_t frames{};
    std::uint64_t bad_checksums{};  ///< Frame starts that were rejected; their first byte is in skipped_bytes.
    std::uint64_t skipped_bytes{};
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls `on_frame(const RvcFrame&, std::size_t bytes_after)` for each frame.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_frame) {
    stats_.bytes += bytes.size();
    while (!bytes.empty()) {
      const std::size_t taken = std::min(bytes.size(), rvc_layout::kFrameBytes - pending_);
      std::memcpy(window_.data() + pending_, bytes.data(), taken);
      pending_ += taken;
      bytes = bytes.subspan(taken);
      RvcFrame frame;
      while (settle(frame)) on_frame(static_cast<const RvcFrame&>(frame), bytes.size());
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
  bool settle(RvcFrame& frame);
  void skip(std::size_t count);

  std::array<std::uint8_t, rvc_layout::kFrameBytes> window_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::imu
