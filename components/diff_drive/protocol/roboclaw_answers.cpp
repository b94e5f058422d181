// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/protocol/roboclaw_answers.hpp"

#include <algorithm>

#include "diff_drive/protocol/big_endian.hpp"

namespace nacelle::diff_drive {
namespace {

constexpr std::uint8_t kAcknowledged = 0xFF;

/// Of an answer, its crc16 included; the shortest one where firmwares differ.
std::size_t answer_bytes(RoboclawCommand command) {
  switch (command) {
    case RoboclawCommand::SerialTimeout:
    case RoboclawCommand::Duty:
    case RoboclawCommand::Speed: return 1;
    case RoboclawCommand::SpeedM1:
    case RoboclawCommand::SpeedM2: return 7;
    case RoboclawCommand::MainBattery: return 4;
    case RoboclawCommand::Encoders: return 10;
    case RoboclawCommand::Status: return 4;
  }
  return 1;
}
constexpr std::size_t kLongStatus = 6;

}  // namespace

void RoboclawAnswers::expect(RoboclawCommand command) {
  const bool is_write = answer_bytes(command) == 1;
  if (awaited_ == kMostAwaited) fall_out_of_step();
  if (in_step_ || is_write) queue_[awaited_++] = command;
}

void RoboclawAnswers::fall_out_of_step() {
  stats_.lost_bytes += pending_;
  pending_ = 0;
  awaited_ = 0;
  if (in_step_) ++stats_.losses;
  in_step_ = false;
}

void RoboclawAnswers::assume_step() {
  if (in_step_) return;
  awaited_ = 0;
  in_step_ = true;
}

bool RoboclawAnswers::has_right_crc() const {
  const std::uint8_t head[] = {address_, static_cast<std::uint8_t>(queue_[0])};
  return crc16_xmodem({buffer_.data(), pending_ - 2}, crc16_xmodem(head)) == load_be16(buffer_.data() + pending_ - 2);
}

RoboclawAnswer RoboclawAnswers::finish() {
  RoboclawAnswer answer;
  answer.command = queue_[0];
  answer.first_byte = stats_.bytes - pending_;
  switch (answer.command) {
    case RoboclawCommand::SpeedM1:
    case RoboclawCommand::SpeedM2: {
      // Some firmwares send a magnitude, some a signed number; the direction's byte is right for both.
      const auto signed_cps = static_cast<std::int32_t>(load_be32(buffer_.data()));
      const std::int32_t magnitude = signed_cps < 0 ? -std::max(signed_cps, -INT32_MAX) : signed_cps;
      answer.value = buffer_[4] == 1 ? -magnitude : magnitude;
      break;
    }
    case RoboclawCommand::Encoders:
      answer.value = static_cast<std::int32_t>(load_be32(buffer_.data()));
      answer.second = static_cast<std::int32_t>(load_be32(buffer_.data() + 4));
      break;
    case RoboclawCommand::MainBattery: answer.value = load_be16(buffer_.data()); break;
    case RoboclawCommand::Status:
      answer.is_old_layout = pending_ != kLongStatus;
      answer.value =
          answer.is_old_layout ? load_be16(buffer_.data()) : static_cast<std::int32_t>(load_be32(buffer_.data()));
      break;
    default: break;
  }
  ++stats_.answers;
  stats_.answer_bytes += pending_;
  pending_ = 0;
  std::shift_left(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(awaited_), 1);
  --awaited_;
  return answer;
}

std::optional<RoboclawAnswer> RoboclawAnswers::take(std::uint8_t byte) {
  ++stats_.bytes;
  if (!in_step_) {
    if (awaited_ == 0 || byte != kAcknowledged) {
      awaited_ = 0;
      ++stats_.lost_bytes;
      return std::nullopt;
    }
    in_step_ = true;
    pending_ = 1;
    return finish();
  }
  if (awaited_ == 0) {
    // Noise, or the answer of a question that an earlier owner asked: what is asked next may be answered by more of it.
    ++stats_.lost_bytes;
    fall_out_of_step();
    return std::nullopt;
  }
  buffer_[pending_++] = byte;
  const RoboclawCommand command = queue_[0];
  const std::size_t length = answer_bytes(command);
  if (length == 1) {
    if (byte == kAcknowledged) return finish();
  } else if (pending_ < length) {
    return std::nullopt;
  } else if (command == RoboclawCommand::Status) {
    if (pending_ != length && pending_ != kLongStatus) return std::nullopt;
    if (has_right_crc()) return finish();
    if (pending_ < kLongStatus) return std::nullopt;
  } else if (has_right_crc()) {
    return finish();
  }
  ++stats_.bad_checksums;
  fall_out_of_step();
  return std::nullopt;
}

}  // namespace nacelle::diff_drive
