// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/hiwonder_frame.hpp"

#include <algorithm>
#include <bit>

namespace nacelle::diff_drive {
namespace {

constexpr std::uint8_t kFrameFirst = 0xAA, kFrameSecond = 0x55;
constexpr std::uint8_t kSystemFunction = 0, kMotorFunction = 3;
constexpr std::uint8_t kSpeedsOfSeveral = 1, kBatteryReport = 4;
constexpr std::size_t kFrameHead = 4;

HiwonderReport report_in(const std::uint8_t* frame) {
  HiwonderReport report;
  report.function = frame[2];
  // Newer firmware appends an alarm to the voltage.
  if (frame[2] == kSystemFunction && frame[3] >= 3 && frame[kFrameHead] == kBatteryReport)
    report.battery_mv = static_cast<std::uint16_t>(frame[kFrameHead + 1] | (frame[kFrameHead + 2] << 8));
  return report;
}

}  // namespace

std::uint8_t crc8_maxim(ByteView bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x8CU : 0U);
  }
  return static_cast<std::uint8_t>(crc);
}

ByteView HiwonderPrinter::speeds(float left_turns_per_s, float right_turns_per_s) {
  frame_ = {kFrameFirst, kFrameSecond, kMotorFunction, kFrame - kFrameHead - 1, kSpeedsOfSeveral, 2};
  std::size_t at = 6;
  const std::array<float, 2> speeds{left_turns_per_s, right_turns_per_s};
  for (std::size_t wheel = 0; wheel < 2; ++wheel) {
    frame_[at++] = static_cast<std::uint8_t>(motors_[wheel] - 1);
    const auto bits = std::bit_cast<std::uint32_t>(speeds[wheel]);
    for (unsigned byte = 0; byte < 4; ++byte) frame_[at++] = static_cast<std::uint8_t>(bits >> (8U * byte));
  }
  frame_[at] = crc8_maxim({frame_.data() + 2, at - 2});
  return frame_;
}

void HiwonderDecoder::restart() {
  stats_.lost_bytes += pending_;
  pending_ = 0;
}

void HiwonderDecoder::drop(std::size_t count) {
  std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
            buffer_.begin() + static_cast<std::ptrdiff_t>(pending_), buffer_.begin());
  pending_ -= count;
}

bool HiwonderDecoder::take(std::optional<HiwonderReport>& report) {
  report.reset();
  if (pending_ == 0) return false;
  if (buffer_[0] == kFrameFirst) {
    if (pending_ < 2) return false;
    if (buffer_[1] == kFrameSecond) {
      if (pending_ < kFrameHead) return false;
      const std::size_t data = buffer_[3];
      if (data <= kMaxData) {
        const std::size_t length = kFrameHead + data + 1;
        if (pending_ < length) return false;
        if (crc8_maxim({buffer_.data() + 2, data + 2}) == buffer_[length - 1]) {
          report = report_in(buffer_.data());
          ++stats_.frames;
          stats_.frame_bytes += length;
          drop(length);
          return true;
        }
        ++stats_.bad_checksums;
      }
    }
  }
  ++stats_.lost_bytes;
  drop(1);
  return true;
}

}  // namespace nacelle::diff_drive
