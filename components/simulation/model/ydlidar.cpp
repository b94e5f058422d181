// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/ydlidar.hpp"

namespace nacelle::simulation {

Ydlidar::Settings Ydlidar::settings_of(std::string_view model) {
  Settings s;
  s.rotor = {.points_per_second = 3000.0, .turns_per_second = 7.0, .farthest_m = 8.0};
  if (model == "ydlidar_x2") return s;
  s.is_commanded = true;
  s.rotor.farthest_m = 16.0;
  if (model == "ydlidar_x4") {
    s.baud = 128000;
    s.rotor.points_per_second = 5000.0;
    s.rotor.farthest_m = 10.0;
    return s;
  }
  s.says_speed = true;
  s.rotor.turns_per_second = 10.0;
  s.baud = model == "ydlidar_g6" ? 512000 : 230400;
  s.model = model == "ydlidar_g2" ? 15 : model == "ydlidar_g4" ? 5 : 13;
  s.has_intensities = model == "ydlidar_g2";
  s.rotor.points_per_second = model == "ydlidar_g2" ? 5000.0 : model == "ydlidar_g4" ? 9000.0 : 18000.0;
  return s;
}

Ydlidar::Ydlidar(const Settings& settings, Room room)
    : settings_(settings), rotor_(settings.rotor, std::move(room)), scans_(!settings.is_commanded) {}

void Ydlidar::set_data_terminal_ready(bool ready) {
  if (!settings_.is_commanded || ready == motor_turns_) return;
  motor_turns_ = ready;
  rotor_.aim_at(ready ? settings_.rotor.turns_per_second : 0.0);
}

void Ydlidar::receive(ByteView bytes, Duration) {
  if (!settings_.is_commanded) return;
  const auto answer = [this](std::initializer_list<std::uint8_t> head, const Bytes& body) {
    outbox_.insert(outbox_.end(), head);
    outbox_.insert(outbox_.end(), body.begin(), body.end());
  };
  for (const std::uint8_t byte : bytes) {
    const bool is_command = std::exchange(awaits_command_, byte == 0xA5 && !awaits_command_);
    if (!is_command) continue;
    if (byte == 0x65) scans_ = false;
    if (byte == 0x60 && health_.first != 2 && !scans_) {
      scans_ = true;
      samples_.clear();
      answer({0xA5, 0x5A, 0x05, 0x00, 0x00, 0x40, 0x81}, {});
    }
    if (byte == 0x90 && !scans_) {
      Bytes info{settings_.model, 1, 2, 3};
      for (std::uint8_t i = 0; i < 16; ++i) info.push_back(i);
      answer({0xA5, 0x5A, 0x14, 0x00, 0x00, 0x00, 0x04}, info);
    }
    if (byte == 0x91 && !scans_) {
      answer({0xA5, 0x5A, 0x03, 0x00, 0x00, 0x00, 0x06}, {health_.first, static_cast<std::uint8_t>(health_.second),
                                                          static_cast<std::uint8_t>(health_.second >> 8U)});
    }
  }
}

void Ydlidar::send_packet(Duration at, bool starts_turn, double turn_hz, const Send& send) {
  if (samples_.empty()) return;
  send(at, print_ydlidar(samples_, starts_turn, turn_hz, settings_.has_intensities));
  samples_.clear();
}

void Ydlidar::advance(Duration now, const Send& send) {
  if (!outbox_.empty()) send(now, std::exchange(outbox_, {}));
  while (rotor_.next_at() <= now) {
    const double rotor_deg = rotor_.next_angle_deg();
    double offset_deg = 0.0;  // where it looks depends on the range that it finds there
    for (int i = 0; i < 4; ++i)
      offset_deg = ydlidar_offset_deg(std::min(rotor_.wall_m(rotor_deg - offset_deg), 30.0) * 1000.0);
    const LidarRotor::Sample sample = rotor_.next(offset_deg);
    if (!scans_) continue;
    // The turn's first sample is a packet of its own, and tells the speed.
    if (sample.starts_turn) send_packet(sample.at, false, 0.0, send);
    const unsigned intensity =
        sample.range_m > 0.0 ? static_cast<unsigned>(std::clamp(900.0 / (1.0 + sample.range_m), 1.0, 1023.0)) : 0;
    samples_.push_back({rotor_deg, sample.range_m * 1000.0, intensity});
    if (sample.starts_turn) {
      send_packet(sample.at, true, settings_.says_speed ? sample.speed_dps / 360.0 : 0.0, send);
    } else if (samples_.size() == 40) {
      send_packet(sample.at, false, 0.0, send);
    }
  }
}

}  // namespace nacelle::simulation
