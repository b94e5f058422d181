// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/vesc_device.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

unsigned checksum(ByteView payload) {
  unsigned crc = 0;
  for (const std::uint8_t byte : payload) {
    crc ^= static_cast<unsigned>(byte) << 8;
    for (int i = 0; i < 8; ++i) crc = ((crc & 0x8000U) != 0 ? (crc << 1) ^ 0x1021U : crc << 1) & 0xFFFFU;
  }
  return crc;
}

void append(Bytes& bytes, std::int64_t value, int count) {
  for (int i = count - 1; i >= 0; --i)
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
}

std::uint32_t word_at(ByteView payload, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = (value << 8) | payload[at + i];
  return value;
}

Bytes framed(const Bytes& payload) {
  Bytes frame{2, static_cast<std::uint8_t>(payload.size())};
  frame.insert(frame.end(), payload.begin(), payload.end());
  append(frame, checksum(payload), 2);
  frame.push_back(3);
  return frame;
}

}  // namespace

// packet.c collects bytes, tries a frame at each of them, and goes on with the next one where it is wrong.
Bytes VescDevice::on_bytes(ByteView bytes, Duration now) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  Bytes answers;
  std::size_t at = 0;
  while (at < buffer_.size()) {
    if (buffer_[at] != 2) {
      ++at;
      continue;
    }
    if (buffer_.size() - at < 2) break;
    const std::size_t length = buffer_[at + 1];
    if (length == 0) {
      ++at;
      continue;
    }
    if (buffer_.size() - at < length + 5) break;
    const ByteView payload{buffer_.data() + at + 2, length};
    const unsigned sent = (buffer_[at + 2 + length] << 8) | buffer_[at + 3 + length];
    if (buffer_[at + 4 + length] != 3 || sent != checksum(payload)) {
      ++stats_.bad_frames;
      ++at;
      continue;
    }
    ++stats_.frames;
    if (payload[0] != 34) {
      obey(0, payload, now, answers);
    } else if (length > 2 && !is_can_cut_) {
      if (payload[1] == settings_.ids[1]) obey(1, payload.subspan(2), now, answers);
    }
    at += length + 5;
  }
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at));
  return answers;
}

void VescDevice::obey(std::size_t motor, ByteView payload, Duration now, Bytes& answers) {
  const std::uint8_t command = payload[0];
  if (command == 0) {
    const Bytes version = framed({0, 6, 5});
    answers.insert(answers.end(), version.begin(), version.end());
  } else if (command == 30) {
    commanded_[motor] = now;
  } else if (command >= 5 && command <= 8 && payload.size() == 5) {
    const auto value = static_cast<double>(static_cast<std::int32_t>(word_at(payload, 1)));
    targets_rps_[motor] = 0.0;  // currents do not turn these wheels
    if (command == 5) targets_rps_[motor] = value * 1e-5 * settings_.full_duty_rps;
    if (command == 8) targets_rps_[motor] = value / settings_.pole_pairs / 60.0 * kTurn_rad;
    commanded_[motor] = now;
  } else if (command == 50 && payload.size() == 5) {
    const Bytes answer = framed(values(motor, word_at(payload, 1)));
    answers.insert(answers.end(), answer.begin(), answer.end());
  }
}

Bytes VescDevice::values(std::size_t motor, std::uint32_t mask) const {
  const double turns = angles_rad_[motor] / kTurn_rad * settings_.pole_pairs;
  const auto erpm = std::llround(rates_rps_[motor] / kTurn_rad * 60.0 * settings_.pole_pairs);
  const auto tachometer = static_cast<std::int64_t>(std::floor(turns * 6.0));
  struct Field {
    std::int64_t value;
    int bytes;
  };
  const Field fields[] = {{300, 2},
                          {250, 2},
                          {0, 4},
                          {0, 4},
                          {0, 4},
                          {0, 4},
                          {0, 2},
                          {erpm, 4},
                          {std::llround(volts_ * 10.0), 2},
                          {0, 4},
                          {0, 4},
                          {0, 4},
                          {0, 4},
                          {tachometer, 4},
                          {std::abs(tachometer), 4},
                          {faults_[motor], 1},
                          {0, 4},
                          {settings_.ids[motor], 1},
                          {0, 6}};
  Bytes payload{50};
  append(payload, mask, 4);
  for (std::size_t bit = 0; bit < std::size(fields); ++bit) {
    if ((mask & (1U << bit)) != 0) append(payload, fields[bit].value, fields[bit].bytes);
  }
  return payload;
}

Bytes VescDevice::step(Duration now, double left_angle_rad, double right_angle_rad) {
  const std::array<double, 2> angles{left_angle_rad, right_angle_rad};
  const double elapsed_s = to_seconds(now - stepped_);
  for (std::size_t motor = 0; motor < 2; ++motor) {
    if (now - commanded_[motor] > settings_.timeout && targets_rps_[motor] != 0.0) {
      ++stats_.timeouts;
      targets_rps_[motor] = 0.0;
    }
    if (elapsed_s > 0.0) rates_rps_[motor] = (angles[motor] - angles_rad_[motor]) / elapsed_s;
  }
  angles_rad_ = angles;
  stepped_ = now;
  return {};
}

}  // namespace nacelle::simulation
