// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

// The frames of a Hiwonder RRC (ROS robot controller). Little-endian.
// Source: Hiwonder, ros_robot_controller_sdk; the firmware's packet_handle.c and packet_reports.h.
//
//   offset  bytes  field
//        0      2  0xAA 0x55
//        2      1  function
//        3      1  n, bytes of the data
//        4      n  data
//      n+4      1  crc8                    MAXIM, over function, n and data
//
//   function        data
//   3 motor, to it  u8 1, u8 count, then of each: u8 motor from 0, f32 turns per second
//   0 system        u8 4, u16 battery                       mV; about once a second
//   7 imu           six f32; as often as its sensor measures

/// CRC-8/MAXIM: polynomial 0x31, reflected, from 0. The check value of "123456789" is 0xA1.
[[nodiscard]] std::uint8_t crc8_maxim(ByteView bytes);

/// Makes frames in its own fixed buffer. Each call overwrites the frame of the call before.
/// Threads: belongs to one thread. Allocates: nothing.
class HiwonderPrinter {
 public:
  static constexpr std::size_t kFrame = 17;
  /// Motors as the board's print and Hiwonder's programs number them: 1 to 4.
  HiwonderPrinter(int left_motor, int right_motor) : motors_{left_motor, right_motor} {}
  /// Units: turns per second of the motors' output shafts.
  [[nodiscard]] ByteView speeds(float left_turns_per_s, float right_turns_per_s);

 private:
  const std::array<int, 2> motors_;
  std::array<std::uint8_t, kFrame> frame_{};
};

/// One frame of the board.
struct HiwonderReport {
  std::uint8_t function = 0;
  std::optional<std::uint16_t> battery_mv;
  friend bool operator==(const HiwonderReport&, const HiwonderReport&) = default;
};

/// Cuts bytes into frames; takes any chopping. A byte that begins no right frame is skipped, and the search goes on behind it.
///
/// Every byte is accounted for: bytes == frame_bytes + lost_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
class HiwonderDecoder {
 public:
  static constexpr std::size_t kMaxData = 64;  ///< The longest report, that of a radio control, has 36.
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t frames = 0, frame_bytes = 0;
    std::uint64_t bad_checksums = 0;
    std::uint64_t lost_bytes = 0;
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_report(const HiwonderReport&) for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_report) {
    for (const std::uint8_t byte : bytes) {
      ++stats_.bytes;
      buffer_[pending_++] = byte;
      std::optional<HiwonderReport> report;
      while (take(report)) {
        if (report) on_report(*report);
      }
    }
  }
  void restart();

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  /// Takes one frame, or one byte that begins none; false if more bytes must come.
  [[nodiscard]] bool take(std::optional<HiwonderReport>& report);
  void drop(std::size_t count);

  std::array<std::uint8_t, kMaxData + 5> buffer_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
