// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "diff_drive/model/drive_kinematics.hpp"
#include "diff_drive/model/wheel_travel.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// A board answers within 10 ms, also behind an adapter that collects bytes for 16 ms. Later an answer counts as missing.
inline constexpr Duration kAnsweredWithin = 50ms;
/// The separator of boards that speak in lines.
inline constexpr std::uint8_t kLineEnd[] = {'\n'};

/// Receives what a motor board reports. Threads: the one that feeds the board.
class BoardEars {
 public:
  BoardEars() = default;
  BoardEars(const BoardEars&) = delete;
  BoardEars& operator=(const BoardEars&) = delete;
  virtual ~BoardEars() = default;

  /// The frame with this reading began with byte number `first_byte` of all bytes that the board was fed.
  virtual void on_wheels(const WheelReading& reading, std::uint64_t first_byte) = 0;
  virtual void on_voltage(double voltage_v) = 0;
  /// The board reports a fault of its own, a text that lives forever; null: it has none.
  virtual void on_fault(const char* fault) = 0;
};

/// What differs between motor boards: the frames that they take, and what their bytes mean.
///
/// SerialBasePort joins it to a line, or to a CAN bus, whose bytes are whole frames (io::CanPort). Views that the functions return stay valid
/// until the next call of the same object.
/// Threads:   one. Allocates: nothing after it was made.
class MotorBoard {
 public:
  struct Stats {
    std::uint64_t bytes = 0;  ///< Fed.
    std::uint64_t lost = 0;   ///< Of them, those that were part of no frame that counts.
  };

  MotorBoard() = default;
  MotorBoard(const MotorBoard&) = delete;
  MotorBoard& operator=(const MotorBoard&) = delete;
  virtual ~MotorBoard() = default;

  /// Discards frames that have begun and forgets requests without an answer: the line starts anew.
  virtual void restart() = 0;
  /// Decodes what the board sent.
  virtual void feed(ByteView bytes, MonotonicTime received_at, BoardEars& ears) = 0;

  /// Returns the frame that stops the wheels. It is the same one for the object's whole life; with separator() at most 64 bytes.
  [[nodiscard]] virtual ByteView stop_frame() const = 0;
  /// Returns the frame for these rates, which are finite and within max_wheel_rate().
  [[nodiscard]] virtual ByteView speed_frame(const WheelRates& rates) = 0;
  /// Returns the frames of a start one by one, after the stop; empty at the end.
  [[nodiscard]] virtual ByteView setup_frame(std::size_t index) = 0;
  /// Returns the next request for feedback; empty if the board sends feedback by itself, or an answer is awaited.
  [[nodiscard]] virtual ByteView next_request(MonotonicTime) { return {}; }
  /// A stop frame or the speed frame for these rates has been written; a stop frame is for rates of zero.
  virtual void on_commanded(MonotonicTime, const WheelRates&) {}
  /// For a board that reports nothing about its wheels: hands over where they are if they turn as commanded. Called after
  /// each wait for bytes.
  virtual void assume_wheels(MonotonicTime, BoardEars&) {}
  /// Returns bytes that end a frame which was sent in part, so that the next one is understood.
  [[nodiscard]] virtual ByteView separator() const = 0;

  /// Returns the highest rate that a command can carry, in rad/s.
  [[nodiscard]] virtual double max_wheel_rate() const = 0;
  /// Positions that the board reports repeat after so many rad; 0: never.
  [[nodiscard]] virtual double position_wrap_rad() const { return 0.0; }
  [[nodiscard]] virtual Stats stats() const = 0;
};

}  // namespace nacelle::diff_drive
