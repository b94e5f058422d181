// SPDX-License-Identifier: Apache-2.0
// Reference firmware of a home-made motor board: both protocols of docs/motor_board_protocol.md, a watchdog, and a speed controller for
// each wheel. Portable C++11 without a heap, exceptions, the standard library's containers or any vendor's header. What differs between
// boards is in the hooks, which your own file writes: timers, PWM, encoders, the serial line.
#pragma once

#include <stdint.h>  // NOLINT(modernize-deprecated-headers): avr-gcc has no <cstdint>

namespace motor_firmware {

/// The board, as functions. `board` is handed to each of them. All are called from byte() and tick(), never from an interrupt.
struct Hooks {
  void* board;
  /// Sends bytes to the host without waiting; what does not fit is lost.
  void (*send)(void* board, const uint8_t* bytes, unsigned count);
  /// Sets a motor's duty, -1 to 1; 0 stops it. Wheel 0 is the left one.
  void (*set_duty)(void* board, int wheel, float duty);
  /// Returns the encoder's count, forward positive; it may wrap.
  int32_t (*counts)(void* board, int wheel);
  /// Returns the battery's voltage in mV; 0: not measured.
  uint16_t (*battery_mv)(void* board);
  /// Returns the fault bits of the protocol; the motors stay off while there are any.
  uint16_t (*faults)(void* board);
};

/// Numbers of the drive. Gains are those of a duty per rad/s.
struct Tuning {
  float counts_per_turn = 1440.0f;
  float feed_forward = 0.05f;  ///< Duty per rad/s; 1 / (rate at full duty) is a good start.
  float proportional = 0.02f;  ///< Duty per rad/s of error.
  float integral = 0.2f;       ///< Duty per rad of error.
};

class MotorFirmware {
 public:
  static constexpr uint32_t kControlPeriodMs = 10;
  static constexpr uint16_t kWatchdogMs = 500;  ///< Until the host sets another.

  MotorFirmware(const Hooks& hooks, const Tuning& tuning);

  /// Call for each byte of the host. `now_ms` wraps.
  void byte(uint8_t value, uint32_t now_ms);
  /// Call as often as possible, at least every 10 ms: watchdog, speed control, reports.
  void tick(uint32_t now_ms);

  /// Returns whether the wheels were stopped because the host was silent.
  bool is_stopped_by_watchdog() const { return watchdog_stopped_; }
  float target_rps(int wheel) const { return target_rps_[wheel]; }

 private:
  static constexpr unsigned kMaxPayload = 32;
  static constexpr unsigned kMaxLine = 48;

  void frame_byte(uint8_t value, uint32_t now_ms);
  void text_byte(uint8_t value, uint32_t now_ms);
  void obey_frame(uint32_t now_ms);
  void obey_line(uint32_t now_ms);
  void command(float left_rps, float right_rps, uint32_t now_ms);
  void stop();
  void control(uint32_t now_ms);
  void report();
  void report_frame();
  void report_text();

  const Hooks hooks_;
  const Tuning tuning_;
  uint8_t frame_[kMaxPayload + 5];
  unsigned frame_size_ = 0;
  char line_[kMaxLine];
  unsigned line_size_ = 0;
  bool line_overflowed_ = false;
  bool speaks_text_ = false;  // the host spoke text last

  float target_rps_[2] = {0.0f, 0.0f};
  float rate_rps_[2] = {0.0f, 0.0f};
  float integral_[2] = {0.0f, 0.0f};
  int32_t counts_[2] = {0, 0};
  uint16_t watchdog_ms_ = kWatchdogMs;
  uint16_t period_ms_ = 20;
  uint32_t commanded_ms_ = 0, controlled_ms_ = 0, reported_ms_ = 0;
  bool has_ticked_ = false;
  bool watchdog_stopped_ = false;
};

}  // namespace motor_firmware
