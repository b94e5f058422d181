// SPDX-License-Identifier: Apache-2.0
#include "imu/protocol/bno055_uart.hpp"

namespace nacelle::imu {

const char* explain_bno055_status(std::uint8_t status) {
  switch (status) {
    case 0x01: return "success";
    case 0x02: return "read failed";
    case 0x03: return "write failed";
    case 0x04: return "no such register";
    case 0x05: return "the register cannot be written in this mode";
    case 0x06: return "wrong start byte";
    case 0x07: return "its bus was overrun";
    case 0x08: return "too many bytes";
    case 0x09: return "too few bytes";
    case 0x0A: return "the request came too slowly";
    default: return "unknown status";
  }
}

bool Bno055AnswerDecoder::take(std::uint8_t byte) {
  using namespace bno055_layout;
  window_[pending_++] = byte;
  if (pending_ == 1) {
    if (byte == kStatus || byte == kData) return false;
    pending_ = 0;
    ++stats_.skipped_bytes;
    return false;
  }
  if (window_[0] == kStatus) return true;
  if (pending_ == 2 && (byte == 0 || byte > kMostData)) {
    // No answer has this length. Its second byte may be the start of one.
    ++stats_.skipped_bytes;
    pending_ = 0;
    return take(byte);
  }
  return pending_ >= 2 && pending_ == std::size_t{2} + window_[1];
}

}  // namespace nacelle::imu
