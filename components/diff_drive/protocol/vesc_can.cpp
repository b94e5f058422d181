// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/vesc_can.hpp"

#include "diff_drive/protocol/big_endian.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr std::uint8_t kShortGetSelected = 50;
constexpr std::uint32_t kOnlyFault = 1U << 15;
constexpr std::uint8_t kProcessAndAnswer = 0;

CanFrame frame_of(VescCanCommand command, std::uint8_t id, std::uint8_t length) {
  CanFrame frame;
  frame.id = (static_cast<std::uint32_t>(command) << 8) | id;
  frame.is_extended = true;
  frame.length = length;
  return frame;
}

std::optional<VescReport> decode_fault(const CanFrame& frame, std::uint8_t receiver) {
  if (receiver != kVescHostId || frame.length < 8 || frame.data[2] != kShortGetSelected ||
      load_be32(frame.data.data() + 3) != kOnlyFault)
    return std::nullopt;
  return VescFaultReport{frame.data[0], frame.data[7]};
}

}  // namespace

std::optional<VescReport> decode_vesc_can(const CanFrame& frame) {
  if (!frame.is_extended || frame.is_request) return std::nullopt;
  const auto id = static_cast<std::uint8_t>(frame.id);
  switch (static_cast<VescCanCommand>(frame.id >> 8)) {
    case VescCanCommand::Status:
      if (frame.length < 8) return std::nullopt;
      return VescSpeed{id, static_cast<std::int32_t>(load_be32(frame.data.data()))};
    case VescCanCommand::Status5:
      if (frame.length < 6) return std::nullopt;
      return VescTravel{id, static_cast<std::int32_t>(load_be32(frame.data.data())),
                        0.1 * static_cast<std::int16_t>(load_be16(frame.data.data() + 4))};
    case VescCanCommand::ShortBuffer: return decode_fault(frame, id);
    default: return std::nullopt;
  }
}

CanFrame vesc_set_rpm(std::uint8_t id, std::int32_t erpm) {
  CanFrame frame = frame_of(VescCanCommand::SetRpm, id, 4);
  store_be32(frame.data.data(), static_cast<std::uint32_t>(erpm));
  return frame;
}

CanFrame vesc_zero_duty(std::uint8_t id) { return frame_of(VescCanCommand::SetDuty, id, 4); }

CanFrame vesc_ask_fault(std::uint8_t id) {
  CanFrame frame = frame_of(VescCanCommand::ShortBuffer, id, 7);
  frame.data[0] = kVescHostId;
  frame.data[1] = kProcessAndAnswer;
  frame.data[2] = kShortGetSelected;
  store_be32(frame.data.data() + 3, kOnlyFault);
  return frame;
}

}  // namespace nacelle::diff_drive
