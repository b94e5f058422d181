// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "diff_drive/protocol/can_frame.hpp"

namespace nacelle::diff_drive {

// VESC over CAN: identifiers of 29 bits, command << 8 | id; big-endian.
// Source: vedderb/bldc, documentation/comm_can.md; comm/comm_can.c and comm/commands.c for command 8.
//
//   command            id           data
//    0  set duty       receiver     i32, 1e-5
//    3  set rpm        receiver     i32, electrical rpm
//    8  short buffer   receiver     u8 sender, u8 what to do (0: process and answer over CAN; answers have 1), then a payload of
//                                   at most 6 bytes, as over UART: here "get selected values" (50, u32 mask) with bit 15 only,
//                                   whose answer is 50, u32 mask, u8 fault
//    9  status         sender       i32 electrical rpm, i16 A * 10, i16 duty * 1000
//   27  status 5       sender       i32 tachometer, six steps per electrical turn; i16 V * 10; 2 bytes reserved
enum class VescCanCommand : std::uint32_t { SetDuty = 0, SetRpm = 3, ShortBuffer = 8, Status = 9, Status5 = 27 };

inline constexpr std::uint8_t kVescHighestId = 253;
inline constexpr std::uint8_t kVescHostId = 254;  ///< Ours, for answers. 255 means every VESC.

struct VescSpeed {
  std::uint8_t id = 0;
  std::int32_t erpm = 0;  ///< Mechanical rpm times pole pairs.
  friend bool operator==(const VescSpeed&, const VescSpeed&) = default;
};
struct VescTravel {
  std::uint8_t id = 0;
  std::int32_t tachometer = 0;  ///< Steps: six per electrical turn.
  double voltage_v = 0.0;
  friend bool operator==(const VescTravel&, const VescTravel&) = default;
};
struct VescFaultReport {
  std::uint8_t id = 0;
  std::uint8_t fault = 0;  ///< mc_fault_code
  friend bool operator==(const VescFaultReport&, const VescFaultReport&) = default;
};
using VescReport = std::variant<VescSpeed, VescTravel, VescFaultReport>;

/// Empty for other commands, for answers to others than kVescHostId, and for data that is too short.
[[nodiscard]] std::optional<VescReport> decode_vesc_can(const CanFrame& frame);
using VescCanDecoder = CanDecoder<&decode_vesc_can>;

[[nodiscard]] CanFrame vesc_set_rpm(std::uint8_t id, std::int32_t erpm);
/// Zero duty: the windings are shorted, which brakes without a speed controller.
[[nodiscard]] CanFrame vesc_zero_duty(std::uint8_t id);
/// Requests VescFaultReport.
[[nodiscard]] CanFrame vesc_ask_fault(std::uint8_t id);

}  // namespace nacelle::diff_drive
