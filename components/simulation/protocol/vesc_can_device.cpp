// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/vesc_can_device.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr double kRevolution_rad = 2.0 * std::numbers::pi;

void push(Bytes& data, std::int64_t value, int count) {
  for (int i = count - 1; i >= 0; --i)
    data.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
}
std::uint32_t pull(const Bytes& data, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = at; i < at + 4; ++i) value = value * 256 + data.at(i);
  return value;
}
CanMessage message_to(unsigned command, std::uint8_t id, Bytes data) {
  return {command * 256 + id, true, false, std::move(data)};
}

}  // namespace

Bytes VescCanDevice::on_bytes(ByteView bytes, Duration now) {
  Bytes answers;
  for (const CanMessage& message : wire_.cut(bytes)) {
    for (std::size_t motor = 0; motor < 2; ++motor) {
      const auto receiver = static_cast<std::uint8_t>(message.id % 256);
      if (message.is_long && !message.is_remote && !is_silent_[motor] &&
          (receiver == settings_.ids[motor] || receiver == 255))
        obey(motor, message.id / 256, message.data, now, answers);
    }
  }
  return answers;
}

void VescCanDevice::obey(std::size_t motor, unsigned command, const Bytes& data, Duration now, Bytes& answers) {
  if ((command == 0 || command == 1 || command == 3) && data.size() >= 4) {
    const double value = static_cast<std::int32_t>(pull(data, 0));
    targets_rps_[motor] = 0.0;  // currents do not turn these wheels
    if (command == 0) targets_rps_[motor] = value * 1e-5 * settings_.full_duty_rps;
    if (command == 3) targets_rps_[motor] = value / settings_.pole_pairs / 60.0 * kRevolution_rad;
    commanded_[motor] = now;
    return;
  }
  // A payload of six bytes or fewer: who sent it, 0 (process it, and answer), the payload. Get selected values: the fault only.
  if (command == 8 && data.size() == 7 && data[1] == 0 && data[2] == 50 && pull(data, 3) == 0x8000) {
    Bytes answer{settings_.ids[motor], 1, 50};
    push(answer, 0x8000, 4);
    answer.push_back(faults_[motor]);
    append(answers, message_to(8, data[0], std::move(answer)));
  }
}

void VescCanDevice::send_status(std::size_t motor, Bytes& bytes) const {
  const double turns = angles_rad_[motor] / kRevolution_rad * settings_.pole_pairs;
  Bytes first, fourth, fifth;
  push(first, std::llround(rates_rps_[motor] / kRevolution_rad * 60.0 * settings_.pole_pairs), 4);
  push(first, 12, 2);
  push(first, 100, 2);
  push(fourth, 300, 2);
  push(fourth, 250, 2);
  push(fourth, 5, 2);
  push(fourth, 0, 2);
  push(fifth, static_cast<std::int64_t>(std::floor(turns * 6.0)), 4);
  push(fifth, std::llround(volts_ * 10.0), 2);
  push(fifth, 0, 2);
  append(bytes, message_to(9, settings_.ids[motor], std::move(first)));
  append(bytes, message_to(16, settings_.ids[motor], std::move(fourth)));
  append(bytes, message_to(27, settings_.ids[motor], std::move(fifth)));
}

Bytes VescCanDevice::step(Duration now, double left_angle_rad, double right_angle_rad) {
  const std::array<double, 2> angles{left_angle_rad, right_angle_rad};
  const double elapsed_s = to_seconds(now - stepped_);
  Bytes bytes;
  for (std::size_t motor = 0; motor < 2; ++motor) {
    if (now - commanded_[motor] > settings_.timeout && targets_rps_[motor] != 0.0) {
      ++timeouts_;
      targets_rps_[motor] = 0.0;
    }
    if (elapsed_s > 0.0) rates_rps_[motor] = (angles[motor] - angles_rad_[motor]) / elapsed_s;
    angles_rad_[motor] = angles[motor];
    if (now - stated_[motor] < settings_.status_period) continue;
    stated_[motor] += (now - stated_[motor]) / settings_.status_period * settings_.status_period;
    if (!is_silent_[motor]) send_status(motor, bytes);
  }
  stepped_ = now;
  return bytes;
}

}  // namespace nacelle::simulation
