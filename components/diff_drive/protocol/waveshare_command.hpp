// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/bytes.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

// What the host sends to a Waveshare UGV board (General Driver for Robots): one JSON object per line, 115200 8N1.
// Source: waveshareteam/ugv_base_ros, ROS_Driver/json_cmd.h and ugv_advance.h.
//
//   T    fields  on the wire             meaning
//     1  L, R    m/s, |x| <= 2.0         wheel speeds over the ground; faster ones are ignored by the board
//   131  cmd     0 or 1                  send base feedback (T 1001) continuously
//   136  cmd     ms                      the board stops when no motion command came for this long (default 3000)
//   142  cmd     ms                      extra delay between feedback lines (default 0)
//   143  cmd     0 or 1                  repeat every command back to the host
//
// Fields of T 1 are written with at most four decimals, 0.1 mm/s.

/// The board ignores faster wheel speeds and keeps the old one: the host must never request more.
inline constexpr double kWaveshareMaxWheelSpeed_mps = 2.0;

/// The prepared stop frame: the command that stops the wheels, ready to be written from any process.
inline constexpr std::array<std::uint8_t, 20> kWaveshareStopFrame = {'{', '"', 'T', '"', ':', '1', ',', '"', 'L', '"',
                                                                     ':', '0', ',', '"', 'R', '"', ':', '0', '}', '\n'};

/// Why a speed command cannot be written; nothing was written.
enum class SpeedCommandFault : std::uint8_t {
  NotFinite,  ///< NaN or infinite.
  TooFast,    ///< Above kWaveshareMaxWheelSpeed_mps: the board would ignore it.
};

/// Prints command lines into its own fixed buffer.
///
/// Each call overwrites the line of the call before; the views stay valid as long as the printer.
/// Threads:   belongs to one thread. Allocates: nothing.
class WaveshareCommandPrinter {
 public:
  /// T 1. Zero speeds give exactly kWaveshareStopFrame.
  [[nodiscard]] Result<ByteView, SpeedCommandFault> wheel_speeds(double left_mps, double right_mps);
  /// T 136. Precondition: positive.
  [[nodiscard]] ByteView motor_watchdog(std::chrono::milliseconds silence);
  /// T 131.
  [[nodiscard]] ByteView continuous_feedback(bool on);
  /// T 142. Precondition: not negative.
  [[nodiscard]] ByteView feedback_delay(std::chrono::milliseconds delay);
  /// T 143.
  [[nodiscard]] ByteView echo(bool on);

 private:
  [[nodiscard]] ByteView number_command(unsigned type, std::int64_t value);

  // {"T":1,"L":-2.0000,"R":-2.0000}\n is the longest speed line; a number command carries at most 20 digits.
  std::array<std::uint8_t, 48> line_{};
};

}  // namespace nacelle::diff_drive
