// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "diff_drive/protocol/can_frame.hpp"

namespace nacelle::diff_drive {

// ODrive's CANSimple: identifiers of 11 bits, node << 5 | command; little-endian. Each axis is a node.
// Source: ODrive documentation, CAN Protocol, firmware 0.5.6 (can-protocol.csv); 0.6 keeps these layouts.
//
//   command                 direction  data
//   0x01  heartbeat         cyclic     u32 axis error, u8 axis state, 3 bytes of flags that differ between firmwares
//   0x07  set axis state    to axis    u32
//   0x09  encoder estimates cyclic or  f32 position, turns; f32 velocity, turns/s
//                           requested
//   0x0B  set modes         to axis    u32 control mode, u32 input mode
//   0x0D  set input vel     to axis    f32 velocity, turns/s; f32 torque, Nm
//   0x17  bus voltage       requested  f32 V, f32 A
//   0x18  clear errors      to axis    u8 0 (0.6: 1 flashes the LED; 0.5 reads nothing)
enum class OdriveCommand : std::uint8_t {
  Heartbeat = 0x01,
  SetAxisState = 0x07,
  EncoderEstimates = 0x09,
  SetControllerModes = 0x0B,
  SetInputVel = 0x0D,
  BusVoltage = 0x17,
  ClearErrors = 0x18,
};
inline constexpr int kOdriveCommandBits = 5;
inline constexpr int kOdriveHighestNode = 62;  ///< 63 means "not addressed" to firmware 0.6.

struct OdriveHeartbeat {
  int node = 0;
  std::uint32_t axis_error = 0;
  std::uint8_t axis_state = 0;
  friend bool operator==(const OdriveHeartbeat&, const OdriveHeartbeat&) = default;
};
struct OdriveMotion {
  int node = 0;
  double position_t = 0.0, velocity_tps = 0.0;  ///< turns, turns/s; finite.
  friend bool operator==(const OdriveMotion&, const OdriveMotion&) = default;
};
struct OdriveVoltage {
  int node = 0;
  double voltage_v = 0.0;
  friend bool operator==(const OdriveVoltage&, const OdriveVoltage&) = default;
};
using OdriveReport = std::variant<OdriveHeartbeat, OdriveMotion, OdriveVoltage>;

/// Empty for other commands, for requests, and for data that is too short or not finite.
[[nodiscard]] std::optional<OdriveReport> decode_odrive(const CanFrame& frame);
using OdriveCanDecoder = CanDecoder<&decode_odrive>;

/// Precondition of all: 0 <= node <= kOdriveHighestNode.
[[nodiscard]] CanFrame odrive_request(int node, OdriveCommand command);
[[nodiscard]] CanFrame odrive_clear_errors(int node);
[[nodiscard]] CanFrame odrive_set_axis_state(int node, std::uint32_t state);
[[nodiscard]] CanFrame odrive_set_modes(int node, std::uint32_t control, std::uint32_t input);
/// Units: turns/s of the motor, Nm.
[[nodiscard]] CanFrame odrive_set_velocity(int node, double velocity_tps, double torque_nm = 0.0);

}  // namespace nacelle::diff_drive
