// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/odrive_can.hpp"

#include <bit>
#include <cmath>

namespace nacelle::diff_drive {
namespace {

constexpr std::uint8_t kWhole = 8;

std::uint32_t word_at(const CanFrame& frame, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i > 0; --i) word = (word << 8) | frame.data[at + i - 1];
  return word;
}
double real_at(const CanFrame& frame, std::size_t at) { return std::bit_cast<float>(word_at(frame, at)); }

void put(CanFrame& frame, std::size_t at, std::uint32_t word) {
  for (std::size_t i = 0; i < 4; ++i) frame.data[at + i] = static_cast<std::uint8_t>(word >> (8 * i));
}
void put(CanFrame& frame, std::size_t at, double real) {
  put(frame, at, std::bit_cast<std::uint32_t>(static_cast<float>(real)));
}

CanFrame frame_of(int node, OdriveCommand command, std::uint8_t length) {
  CanFrame frame;
  frame.id = (static_cast<std::uint32_t>(node) << kOdriveCommandBits) | static_cast<std::uint32_t>(command);
  frame.length = length;
  return frame;
}

}  // namespace

std::optional<OdriveReport> decode_odrive(const CanFrame& frame) {
  if (frame.is_extended || frame.is_request) return std::nullopt;
  const int node = static_cast<int>(frame.id >> kOdriveCommandBits);
  switch (static_cast<OdriveCommand>(frame.id & ((1U << kOdriveCommandBits) - 1))) {
    case OdriveCommand::Heartbeat:
      if (frame.length < 5) return std::nullopt;
      return OdriveHeartbeat{node, word_at(frame, 0), frame.data[4]};
    case OdriveCommand::EncoderEstimates: {
      const OdriveMotion motion{node, real_at(frame, 0), real_at(frame, 4)};
      if (frame.length < kWhole || !std::isfinite(motion.position_t) || !std::isfinite(motion.velocity_tps))
        return std::nullopt;
      return motion;
    }
    case OdriveCommand::BusVoltage: {
      const OdriveVoltage voltage{node, real_at(frame, 0)};
      if (frame.length < 4 || !std::isfinite(voltage.voltage_v)) return std::nullopt;
      return voltage;
    }
    default: return std::nullopt;
  }
}

CanFrame odrive_request(int node, OdriveCommand command) {
  CanFrame frame = frame_of(node, command, kWhole);  // of a request the length is that of the answer
  frame.is_request = true;
  return frame;
}

CanFrame odrive_clear_errors(int node) { return frame_of(node, OdriveCommand::ClearErrors, 1); }

CanFrame odrive_set_axis_state(int node, std::uint32_t state) {
  CanFrame frame = frame_of(node, OdriveCommand::SetAxisState, 4);
  put(frame, 0, state);
  return frame;
}

CanFrame odrive_set_modes(int node, std::uint32_t control, std::uint32_t input) {
  CanFrame frame = frame_of(node, OdriveCommand::SetControllerModes, kWhole);
  put(frame, 0, control);
  put(frame, 4, input);
  return frame;
}

CanFrame odrive_set_velocity(int node, double velocity_tps, double torque_nm) {
  CanFrame frame = frame_of(node, OdriveCommand::SetInputVel, kWhole);
  put(frame, 0, velocity_tps);
  put(frame, 4, torque_nm);
  return frame;
}

}  // namespace nacelle::diff_drive
