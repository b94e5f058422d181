// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/roboclaw_packet.hpp"

#include "diff_drive/protocol/big_endian.hpp"

namespace nacelle::diff_drive {
namespace {

struct FaultBit {
  std::uint32_t bit;
  const char* text;
};
constexpr const char* kEmergencyStop = "RoboClaw: the emergency stop input is set (E-stop)";
constexpr const char* kDriver1 = "RoboClaw: fault of the driver of M1";
constexpr const char* kDriver2 = "RoboClaw: fault of the driver of M2";
constexpr const char* kTemperature = "RoboClaw: the board is too hot";
constexpr const char* kTemperature2 = "RoboClaw: the second sensor of the board is too hot";
constexpr const char* kMainHigh = "RoboClaw: the main battery's voltage is too high";
constexpr const char* kLogicHigh = "RoboClaw: the logic battery's voltage is too high";
constexpr const char* kLogicLow = "RoboClaw: the logic battery's voltage is too low";

// Source: Basicmicro user manual, command 90; the layout of 32 bits is that of newer firmware.
constexpr FaultBit kNewFaults[] = {
    {0x1, kEmergencyStop},
    {0x40, kDriver1},
    {0x80, kDriver2},
    {0x2, kTemperature},
    {0x4, kTemperature2},
    {0x8, kMainHigh},
    {0x10, kLogicHigh},
    {0x20, kLogicLow},
    {0x100, "RoboClaw: M1 does not reach its speed (speed error)"},
    {0x200, "RoboClaw: M2 does not reach its speed (speed error)"},
    {0x400, "RoboClaw: position error of M1"},
    {0x800, "RoboClaw: position error of M2"},
    {0x1000, "RoboClaw: current error of M1"},
    {0x2000, "RoboClaw: current error of M2"},
};
constexpr FaultBit kOldFaults[] = {
    {0x4, kEmergencyStop}, {0x100, kDriver1}, {0x200, kDriver2},  {0x8, kTemperature},
    {0x10, kTemperature2}, {0x20, kMainHigh}, {0x40, kLogicHigh}, {0x80, kLogicLow},
};

}  // namespace

ByteView RoboclawPrinter::finish(RoboclawCommand command, std::size_t data_bytes) {
  packet_[0] = address_;
  packet_[1] = static_cast<std::uint8_t>(command);
  store_be16(packet_.data() + 2 + data_bytes, crc16_xmodem({packet_.data(), 2 + data_bytes}));
  return {packet_.data(), 4 + data_bytes};
}

ByteView RoboclawPrinter::speeds(std::int32_t m1_cps, std::int32_t m2_cps) {
  store_be32(packet_.data() + 2, static_cast<std::uint32_t>(m1_cps));
  store_be32(packet_.data() + 6, static_cast<std::uint32_t>(m2_cps));
  return finish(RoboclawCommand::Speed, 8);
}

ByteView RoboclawPrinter::duties(std::int16_t m1, std::int16_t m2) {
  store_be16(packet_.data() + 2, static_cast<std::uint16_t>(m1));
  store_be16(packet_.data() + 4, static_cast<std::uint16_t>(m2));
  return finish(RoboclawCommand::Duty, 4);
}

ByteView RoboclawPrinter::serial_timeout(std::uint8_t tenths_s) {
  packet_[2] = tenths_s;
  return finish(RoboclawCommand::SerialTimeout, 1);
}

ByteView RoboclawPrinter::read(RoboclawCommand command) {
  packet_[0] = address_;
  packet_[1] = static_cast<std::uint8_t>(command);
  return {packet_.data(), 2};
}

const char* roboclaw_fault(std::uint32_t status, bool is_old_layout) {
  if (is_old_layout) {
    for (const FaultBit& fault : kOldFaults) {
      if ((status & fault.bit) != 0) return fault.text;
    }
    return nullptr;
  }
  for (const FaultBit& fault : kNewFaults) {
    if ((status & fault.bit) != 0) return fault.text;
  }
  return nullptr;
}

}  // namespace nacelle::diff_drive
