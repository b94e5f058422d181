// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/hiwonder_device.hpp"

#include <cstring>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr std::uint8_t kFunctions = 12;  // the firmware takes no number from here on
constexpr Duration kBatteryPeriod = 1050ms;

// The eight steps of a byte, most significant bit first over reflected bits.
std::uint8_t reflected(std::uint8_t byte) {
  std::uint8_t turned = 0;
  for (int i = 0; i < 8; ++i) turned = static_cast<std::uint8_t>((turned << 1) | ((byte >> i) & 1));
  return turned;
}

std::uint8_t report_checksum(std::uint8_t function, const Bytes& data) {
  std::uint8_t crc = 0;
  const auto add = [&crc](std::uint8_t byte) {
    crc = static_cast<std::uint8_t>(crc ^ reflected(byte));
    for (int i = 0; i < 8; ++i) crc = static_cast<std::uint8_t>((crc << 1) ^ ((crc & 0x80) != 0 ? 0x31 : 0));
  };
  add(function);
  add(static_cast<std::uint8_t>(data.size()));
  for (const std::uint8_t byte : data) add(byte);
  return reflected(crc);
}

void append_report(Bytes& out, std::uint8_t function, const Bytes& data) {
  out.insert(out.end(), {0xAA, 0x55, function, static_cast<std::uint8_t>(data.size())});
  out.insert(out.end(), data.begin(), data.end());
  out.push_back(report_checksum(function, data));
}

}  // namespace

double HiwonderDevice::speed_of(std::size_t motor) const {
  return 2.0 * std::numbers::pi * static_cast<double>(turns_per_s_[motor]);
}

// packet.c: a state for each field, and nothing is read twice.
void HiwonderDevice::take(std::uint8_t byte) {
  switch (awaited_) {
    case Awaited::First: awaited_ = byte == 0xAA ? Awaited::Second : Awaited::First; break;
    case Awaited::Second: awaited_ = byte == 0x55 ? Awaited::Function : Awaited::First; break;
    case Awaited::Function:
      function_ = byte;
      awaited_ = byte < kFunctions ? Awaited::Length : Awaited::First;
      break;
    case Awaited::Length:
      length_ = byte;
      data_.clear();
      awaited_ = byte == 0 ? Awaited::Check : Awaited::Data;
      break;
    case Awaited::Data:
      data_.push_back(byte);
      if (data_.size() == length_) awaited_ = Awaited::Check;
      break;
    case Awaited::Check:
      if (byte == report_checksum(function_, data_)) {
        obey();
      } else {
        ++bad_frames_;
      }
      awaited_ = Awaited::First;
      break;
  }
}

void HiwonderDevice::obey() {
  if (function_ != 3 || data_.size() < 2 || data_[0] != 1) return;
  for (std::size_t i = 0; i < data_[1] && 7 + 5 * i <= data_.size(); ++i) {
    const std::uint8_t* const element = data_.data() + 2 + 5 * i;
    if (element[0] >= turns_per_s_.size()) continue;
    const std::uint32_t bits = element[1] | (std::uint32_t{element[2]} << 8) | (std::uint32_t{element[3]} << 16) |
                               (std::uint32_t{element[4]} << 24);
    std::memcpy(&turns_per_s_[element[0]], &bits, sizeof bits);
  }
  ++commands_;
}

Bytes HiwonderDevice::on_bytes(ByteView bytes, Duration) {
  for (const std::uint8_t byte : bytes) take(byte);
  return {};
}

Bytes HiwonderDevice::step(Duration now, double, double) {
  Bytes sent;
  if (is_silent_) return sent;
  if (has_imu_) {
    Bytes imu(24, 0);
    imu[10] = 0x80;  // 1 g on z
    imu[11] = 0x3F;
    append_report(sent, 7, imu);
  }
  if (now - battery_at_ >= kBatteryPeriod) {
    battery_at_ = now;
    append_report(sent, 0, {4, static_cast<std::uint8_t>(battery_mv_), static_cast<std::uint8_t>(battery_mv_ >> 8)});
  }
  return sent;
}

}  // namespace nacelle::simulation
