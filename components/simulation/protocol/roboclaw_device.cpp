// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/roboclaw_device.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr Duration kLongestGap = 10ms;  // source: the manual's "10 ms" between the bytes of a packet

/// Bit by bit, as the manual prints it.
std::uint16_t crc16(const std::uint8_t* bytes, std::size_t count) {
  unsigned crc = 0;
  for (std::size_t i = 0; i < count; ++i) {
    crc ^= static_cast<unsigned>(bytes[i]) << 8;
    for (int bit = 0; bit < 8; ++bit) {
      if ((crc & 0x8000U) != 0) {
        crc = (crc << 1) ^ 0x1021U;
      } else {
        crc <<= 1;
      }
    }
  }
  return static_cast<std::uint16_t>(crc & 0xFFFFU);
}

void put(Bytes& bytes, std::uint64_t value, int count) {
  for (int shift = 8 * (count - 1); shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

std::int64_t signed_at(const Bytes& packet, std::size_t at, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = (value << 8) | packet[at + i];
  const std::uint64_t sign = std::uint64_t{1} << (8 * count - 1);
  return static_cast<std::int64_t>(value ^ sign) - static_cast<std::int64_t>(sign);
}

/// Data bytes of the commands that write; nothing for those that read.
std::optional<std::size_t> write_bytes(std::uint8_t command) {
  switch (command) {
    case 14: return 1;
    case 20: return 0;
    case 32:
    case 33: return 2;
    case 34:
    case 35:
    case 36: return 4;
    case 37: return 8;
    default: return std::nullopt;
  }
}

}  // namespace

void RoboclawDevice::restart() {
  buffer_.clear();
  timeout_tenths_ = 0;
  targets_cps_ = {};
  zero_ = counts_;
}

Bytes RoboclawDevice::on_bytes(ByteView bytes, Duration now) {
  if (!buffer_.empty() && now - last_byte_ > kLongestGap) {
    ++stats_.torn_packets;
    buffer_.clear();
  }
  last_byte_ = now;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  Bytes answer;
  while (!buffer_.empty()) {
    if (buffer_[0] != settings_.address) {
      ++stats_.stray_bytes;
      buffer_.erase(buffer_.begin());
      continue;
    }
    const std::size_t before = answer.size();
    const auto taken = handle(buffer_, answer);
    if (!taken) break;
    if (answer.size() != before) last_packet_ = now;
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(*taken));
  }
  return answer;
}

void RoboclawDevice::answer_read(const Bytes& packet, const Bytes& data, Bytes& answer) const {
  Bytes checked{packet[0], packet[1]};
  checked.insert(checked.end(), data.begin(), data.end());
  answer.insert(answer.end(), data.begin(), data.end());
  put(answer, crc16(checked.data(), checked.size()), 2);
}

Bytes RoboclawDevice::speed_of(std::size_t motor) const {
  const auto cps = static_cast<std::int64_t>(std::llround(speeds_cps_[motor]));
  Bytes data;
  put(data, static_cast<std::uint64_t>(settings_.sends_magnitudes ? std::abs(cps) : cps), 4);
  put(data, cps < 0 ? 1 : 0, 1);
  return data;
}

std::optional<std::size_t> RoboclawDevice::handle(const Bytes& packet, Bytes& answer) {
  if (packet.size() < 2) return std::nullopt;
  const std::uint8_t command = packet[1];
  if (const auto data_bytes = write_bytes(command)) {
    const std::size_t length = 2 + *data_bytes + 2;
    if (packet.size() < length) return std::nullopt;
    const auto crc = static_cast<std::uint16_t>((packet[length - 2] << 8) | packet[length - 1]);
    if (crc != crc16(packet.data(), length - 2)) {
      ++stats_.bad_checksums;
      return length;
    }
    const double per_duty = settings_.full_duty_rps / (2.0 * std::numbers::pi) * settings_.counts_per_turn / 32767.0;
    switch (command) {
      case 14: timeout_tenths_ = packet[2]; break;
      case 20: zero_ = counts_; break;
      case 32: targets_cps_[0] = static_cast<double>(signed_at(packet, 2, 2)) * per_duty; break;
      case 33: targets_cps_[1] = static_cast<double>(signed_at(packet, 2, 2)) * per_duty; break;
      case 34:
        targets_cps_ = {static_cast<double>(signed_at(packet, 2, 2)) * per_duty,
                        static_cast<double>(signed_at(packet, 4, 2)) * per_duty};
        break;
      case 35: targets_cps_[0] = static_cast<double>(signed_at(packet, 2, 4)); break;
      case 36: targets_cps_[1] = static_cast<double>(signed_at(packet, 2, 4)); break;
      default:
        targets_cps_ = {static_cast<double>(signed_at(packet, 2, 4)), static_cast<double>(signed_at(packet, 6, 4))};
    }
    answer.push_back(0xFF);
    ++stats_.packets;
    return length;
  }
  const auto count = [this](std::size_t motor) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(counts_[motor] - zero_[motor])));
  };
  Bytes data;
  switch (command) {
    case 15: put(data, timeout_tenths_, 1); break;
    case 16:
    case 17:
      put(data, count(command - 16U), 4);
      put(data, 0, 1);
      break;
    case 18: data = speed_of(0); break;
    case 19: data = speed_of(1); break;
    case 24: put(data, tenths_v_, 2); break;
    case 78:
      put(data, count(0), 4);
      put(data, count(1), 4);
      break;
    case 90: put(data, status_, settings_.has_old_firmware ? 2 : 4); break;
    default: ++stats_.stray_bytes; return 1;  // a command that this board does not know: no answer
  }
  answer_read(packet, data, answer);
  ++stats_.packets;
  return 2;
}

double RoboclawDevice::target_rps(std::size_t motor) const {
  if ((status_ & 0xFFFU) != 0) return 0.0;  // an error: the motors are off
  return targets_cps_[motor] / settings_.counts_per_turn * 2.0 * std::numbers::pi;
}

Bytes RoboclawDevice::step(Duration now, double left_angle_rad, double right_angle_rad) {
  if (timeout_tenths_ != 0 && now - last_packet_ > timeout_tenths_ * 100ms &&
      (targets_cps_[0] != 0.0 || targets_cps_[1] != 0.0)) {
    ++stats_.timeouts;
    targets_cps_ = {};
  }
  const double per_rad = settings_.counts_per_turn / (2.0 * std::numbers::pi);
  const std::array<double, 2> before = counts_;
  counts_ = {left_angle_rad * per_rad, right_angle_rad * per_rad};
  if (const double elapsed_s = to_seconds(now - stepped_); elapsed_s > 0.0) {
    for (std::size_t i = 0; i < 2; ++i) speeds_cps_[i] = (counts_[i] - before[i]) / elapsed_s;
  }
  stepped_ = now;
  return {};
}

}  // namespace nacelle::simulation
