// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/motor_frame.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "diff_drive/protocol/big_endian.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr std::uint8_t kMotorFrameStart = 0xA5;
constexpr std::uint8_t kSpeeds = 0x01, kStop = 0x02, kSettings = 0x03, kState = 0x81;
constexpr std::size_t kStateBytes = 20;

std::uint32_t load_le32(const std::uint8_t* at) {
  return static_cast<std::uint32_t>(load_le16(at)) | (static_cast<std::uint32_t>(load_le16(at + 2)) << 16);
}
void store_le32(std::uint8_t* at, std::uint32_t value) {
  store_le16(at, static_cast<std::uint16_t>(value));
  store_le16(at + 2, static_cast<std::uint16_t>(value >> 16));
}

std::optional<MotorFrameState> decode(const std::uint8_t* payload) {
  MotorFrameState state;
  state.left_counts = static_cast<std::int32_t>(load_le32(payload));
  state.right_counts = static_cast<std::int32_t>(load_le32(payload + 4));
  state.left_rps = std::bit_cast<float>(load_le32(payload + 8));
  state.right_rps = std::bit_cast<float>(load_le32(payload + 12));
  state.battery_mv = load_le16(payload + 16);
  state.faults = load_le16(payload + 18);
  if (!std::isfinite(state.left_rps) || !std::isfinite(state.right_rps)) return std::nullopt;
  return state;
}

}  // namespace

ByteView MotorFramePrinter::finish(std::uint8_t type, std::size_t payload_bytes) {
  frame_[0] = kMotorFrameStart;
  frame_[1] = type;
  frame_[2] = static_cast<std::uint8_t>(payload_bytes);
  store_le16(frame_.data() + 3 + payload_bytes, crc16_xmodem({frame_.data() + 1, 2 + payload_bytes}));
  return {frame_.data(), 5 + payload_bytes};
}

ByteView MotorFramePrinter::speeds(float left_rps, float right_rps) {
  store_le32(frame_.data() + 3, std::bit_cast<std::uint32_t>(left_rps));
  store_le32(frame_.data() + 7, std::bit_cast<std::uint32_t>(right_rps));
  return finish(kSpeeds, 8);
}

ByteView MotorFramePrinter::stop() { return finish(kStop, 0); }

ByteView MotorFramePrinter::settings(std::uint16_t watchdog_ms, std::uint16_t period_ms) {
  store_le16(frame_.data() + 3, watchdog_ms);
  store_le16(frame_.data() + 5, period_ms);
  return finish(kSettings, 4);
}

const char* motor_frame_fault(std::uint16_t faults) {
  struct Bit {
    std::uint16_t bit;
    const char* text;
  };
  static constexpr Bit kBits[] = {
      {0x01, "motor board: its emergency stop input is set"}, {0x02, "motor board: the driver of the left motor"},
      {0x04, "motor board: the driver of the right motor"},   {0x08, "motor board: too hot"},
      {0x10, "motor board: the battery's voltage"},           {0x20, "motor board: an encoder"},
      {0xFFFF, "motor board: a fault without a name"},
  };
  for (const Bit& fault : kBits) {
    if ((faults & fault.bit) != 0) return fault.text;
  }
  return nullptr;
}

void MotorFrameDecoder::restart() {
  stats_.lost_bytes += pending_;
  pending_ = 0;
}

void MotorFrameDecoder::drop(std::size_t count) {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
            buffer_.begin() + static_cast<std::ptrdiff_t>(pending_), buffer_.begin());
  pending_ -= count;
}

bool MotorFrameDecoder::take(std::optional<MotorFrameState>& state) {
  state.reset();
  if (pending_ == 0) return false;
  if (buffer_[0] == kMotorFrameStart) {
    if (pending_ < 3) return false;
    const std::size_t payload = buffer_[2];
    if (payload <= kMaxPayload) {
      const std::size_t length = payload + 5;
      if (pending_ < length) return false;
      if (crc16_xmodem({buffer_.data() + 1, payload + 2}) == load_le16(buffer_.data() + 3 + payload)) {
        if (buffer_[1] == kState && payload == kStateBytes) state = decode(buffer_.data() + 3);
        if (state) {
          state->first_byte = stats_.bytes - pending_;
          ++stats_.states;
          stats_.state_bytes += length;
        } else {
          ++stats_.other_frames;
          stats_.other_bytes += length;
        }
        drop(length);
        return true;
      }
      ++stats_.bad_checksums;
    }
  }
  ++stats_.lost_bytes;
  drop(1);
  return true;
}

}  // namespace nacelle::diff_drive
