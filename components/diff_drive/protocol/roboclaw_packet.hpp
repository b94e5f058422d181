// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::diff_drive {

// RoboClaw's packet serial mode, big-endian. The host speaks, the board answers in the same order, without an address.
// Source: Basicmicro, RoboClaw user manual, "Packet Serial"; numbers of the commands from Basicmicro's Arduino library.
//
//   write     address, command, data, crc16 of all of these          answer: 0xFF
//   read      address, command                                       answer: data, crc16 of address, command and data
//
//   command                  data                                    answer
//     14  serial timeout     u8, 0.1 s; 0 off                        0xFF
//     18  speed M1           -                                       u32 counts/s, u8 1 = backward
//     19  speed M2           -                                       as 18
//     24  main battery       -                                       u16, 0.1 V
//     34  duty M1, M2        i16, i16: +-32767                       0xFF
//     37  speed M1, M2       i32, i32 counts/s                       0xFF
//     78  encoders           -                                       i32 M1, i32 M2: counts
//     90  status             -                                       u16 (older firmware) or u32
//
// The board drops a packet whose bytes are more than 10 ms apart, and one whose crc16 is wrong, without an answer.

/// The commands that the base uses.
enum class RoboclawCommand : std::uint8_t {
  SerialTimeout = 14,
  SpeedM1 = 18,
  SpeedM2 = 19,
  MainBattery = 24,
  Duty = 34,
  Speed = 37,
  Encoders = 78,
  Status = 90,
};

/// Makes packets in its own fixed buffer. Each call overwrites the packet of the call before.
/// Threads: belongs to one thread. Allocates: nothing.
class RoboclawPrinter {
 public:
  /// Precondition: 0x80 to 0x87.
  explicit RoboclawPrinter(std::uint8_t address) : address_(address) {}

  /// Command 37, in counts/s.
  [[nodiscard]] ByteView speeds(std::int32_t m1_cps, std::int32_t m2_cps);
  /// Command 34, in 1/32767 of the battery's voltage.
  [[nodiscard]] ByteView duties(std::int16_t m1, std::int16_t m2);
  /// Command 14: the motors stop after this silence; 0 switches the timeout off.
  [[nodiscard]] ByteView serial_timeout(std::uint8_t tenths_s);
  /// A command that reads.
  [[nodiscard]] ByteView read(RoboclawCommand command);

  static constexpr std::size_t kLongest = 12;

 private:
  [[nodiscard]] ByteView finish(RoboclawCommand command, std::size_t data_bytes);

  const std::uint8_t address_;
  std::array<std::uint8_t, kLongest> packet_{};
};

/// Returns the gravest fault of a status word, a text that lives forever; null if it holds none. Warnings are no faults.
[[nodiscard]] const char* roboclaw_fault(std::uint32_t status, bool is_old_layout);

}  // namespace nacelle::diff_drive
