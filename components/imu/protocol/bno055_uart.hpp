// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"

namespace nacelle::imu {

namespace bno055_layout {
// BNO055 on a serial line: 115200 baud, the host asks and the device answers. Source: BNO055 data sheet, section 4.7 (page 94).
//
//   host: write  aa 00 register length data     device: ee status
//   host: read   aa 01 register length          device: bb length data, or ee status
//
//   status 01 is success; 07, a bus overrun, is common: the host asks again
inline constexpr std::uint8_t kStart = 0xAA, kWrite = 0x00, kRead = 0x01, kStatus = 0xEE, kData = 0xBB;
inline constexpr std::uint8_t kSuccess = 0x01, kOverrun = 0x07;
inline constexpr std::size_t kRequestBytes = 4, kMostData = 128;
}  // namespace bno055_layout

/// "register map address wrong"; what the device's status says, by its data sheet.
[[nodiscard]] const char* explain_bno055_status(std::uint8_t status);

using Bno055Request = std::array<std::uint8_t, bno055_layout::kRequestBytes + 1>;
/// The whole request.
[[nodiscard]] constexpr Bno055Request bno055_write(std::uint8_t reg, std::uint8_t value) {
  return {bno055_layout::kStart, bno055_layout::kWrite, reg, 1, value};
}
/// Without its last byte. Precondition: 1 to 128 bytes.
[[nodiscard]] constexpr Bno055Request bno055_read(std::uint8_t reg, std::size_t length) {
  return {bno055_layout::kStart, bno055_layout::kRead, reg, static_cast<std::uint8_t>(length), 0};
}

/// One answer of the device.
struct Bno055Answer {
  std::uint8_t status = bno055_layout::kSuccess;
  ByteView data{};  ///< Of a read; valid until the decoder is fed again.
};

/// Finds answers in a stream of bytes, however it is chopped. There is no checksum: an answer of another length than the one that was
/// asked for is for the caller to refuse.
///
/// Threads: one. Allocates: nothing.
class Bno055AnswerDecoder {
 public:
  /// Every byte that was fed is in one place: bytes == answer_bytes + skipped_bytes + pending().
  struct Stats {
    std::uint64_t bytes{}, answers{}, answer_bytes{};
    std::uint64_t skipped_bytes{};
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls `on_answer(const Bno055Answer&)` for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_answer) {
    stats_.bytes += bytes.size();
    for (const std::uint8_t byte : bytes) {
      if (!take(byte)) continue;
      const bool is_status = window_[0] == bno055_layout::kStatus;
      ++stats_.answers;
      stats_.answer_bytes += pending_;
      const std::size_t length = pending_;
      pending_ = 0;
      on_answer(is_status ? Bno055Answer{window_[1], {}}
                          : Bno055Answer{bno055_layout::kSuccess, ByteView{window_}.subspan(2, length - 2)});
    }
  }

  /// Forgets half an answer.
  void restart() {
    stats_.skipped_bytes += pending_;
    pending_ = 0;
  }
  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  /// True: the window holds a whole answer.
  bool take(std::uint8_t byte);

  std::array<std::uint8_t, 2 + bno055_layout::kMostData> window_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::imu
