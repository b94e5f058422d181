// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

// The framed protocol of home-made boards: docs/motor_board_protocol.md. Little-endian.
//
//   offset  bytes  field
//        0      1  0xA5
//        1      1  type
//        2      1  n, bytes of the payload: 0 to 32
//        3      n  payload
//      n+3      2  crc16                   XMODEM, over type, n and payload
//
//   type            payload
//   0x01 speeds     f32 left, f32 right                     rad/s of the wheels
//   0x02 stop       -
//   0x03 settings   u16 watchdog, u16 period of states      ms; 0 leaves what the board has
//   0x81 state      i32 left, i32 right                     counts of the encoders
//                   f32 left, f32 right                     rad/s of the wheels
//                   u16 battery                             mV; 0 unknown
//                   u16 faults                              bits, see motor_frame_fault()

/// Makes frames in its own fixed buffer. Each call overwrites the frame of the call before.
/// Threads: belongs to one thread. Allocates: nothing.
class MotorFramePrinter {
 public:
  static constexpr std::size_t kLongest = 13;
  [[nodiscard]] ByteView speeds(float left_rps, float right_rps);
  [[nodiscard]] ByteView stop();
  [[nodiscard]] ByteView settings(std::uint16_t watchdog_ms, std::uint16_t period_ms);

 private:
  [[nodiscard]] ByteView finish(std::uint8_t type, std::size_t payload_bytes);
  std::array<std::uint8_t, kLongest> frame_{};
};

/// One frame of type 0x81.
struct MotorFrameState {
  std::int32_t left_counts = 0, right_counts = 0;
  float left_rps = 0.0F, right_rps = 0.0F;  ///< Finite.
  std::uint16_t battery_mv = 0;
  std::uint16_t faults = 0;
  std::uint64_t first_byte = 0;  ///< The number of its first byte among all bytes that were fed.
  friend bool operator==(const MotorFrameState&, const MotorFrameState&) = default;
};

/// Returns the gravest fault, a text that lives forever; null if there is none.
[[nodiscard]] const char* motor_frame_fault(std::uint16_t faults);

/// Cuts bytes into frames; takes any chopping. A byte that begins no right frame is skipped, and the search goes on behind it.
///
/// Every byte is accounted for: bytes == state_bytes + other_bytes + lost_bytes + pending().
/// Threads: belongs to one thread. Allocates: nothing.
class MotorFrameDecoder {
 public:
  static constexpr std::size_t kMaxPayload = 32;
  struct Stats {
    std::uint64_t bytes = 0;
    std::uint64_t states = 0, state_bytes = 0;
    std::uint64_t other_frames = 0,
                  other_bytes = 0;  ///< Of types that are not known here, and states that are not finite.
    std::uint64_t bad_checksums = 0;
    std::uint64_t lost_bytes = 0;
    friend bool operator==(const Stats&, const Stats&) = default;
  };

  /// Calls on_state(const MotorFrameState&) for each.
  template <typename Sink>
  void feed(ByteView bytes, Sink&& on_state) {
    for (const std::uint8_t byte : bytes) {
      ++stats_.bytes;
      buffer_[pending_++] = byte;
      std::optional<MotorFrameState> state;
      while (take(state)) {
        if (state) on_state(*state);
      }
    }
  }
  void restart();

  [[nodiscard]] const Stats& stats() const { return stats_; }
  [[nodiscard]] std::size_t pending() const { return pending_; }

 private:
  /// Takes one frame, or one byte that begins none; false if more bytes must come.
  [[nodiscard]] bool take(std::optional<MotorFrameState>& state);
  void drop(std::size_t count);

  std::array<std::uint8_t, kMaxPayload + 5> buffer_{};
  std::size_t pending_ = 0;
  Stats stats_;
};

}  // namespace nacelle::diff_drive
