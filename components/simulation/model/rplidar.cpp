// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/rplidar.hpp"

namespace nacelle::simulation {
namespace {

std::size_t points_in(std::uint8_t answer) {
  return answer == 0x82 ? 32 : answer == 0x85 ? 40 : answer == 0x84 ? 96 : 1;
}

std::uint32_t bytes_in(std::uint8_t answer) { return answer == 0x81 ? 5 : answer == 0x84 ? 132 : 84; }

/// A time-of-flight sensor looks along its axis.
bool triangulates(std::uint8_t model) { return model >> 4U < 4; }

Bytes little_endian(std::uint32_t value, std::size_t bytes) {
  Bytes result;
  for (std::size_t i = 0; i < bytes; ++i) result.push_back(static_cast<std::uint8_t>(value >> 8U * i));
  return result;
}

}  // namespace

Rplidar::Settings Rplidar::settings_of(std::string_view model) {
  Settings s;
  s.modes = {{"Standard", 0x81, 508.0}, {"Express", 0x82, 254.0}, {"Boost", 0x82, 127.0}};
  s.typical_mode = 1;
  s.rotor.turns_per_second = 5.5;
  if (model == "rplidar_a2" || model == "rplidar_a3") {
    s.model = model == "rplidar_a2" ? 0x28 : 0x31;
    s.motor = Motor::Pwm;
    s.modes[2] = {"Boost", 0x84, 63.0};
    s.rotor.turns_per_second = 10.0;
    if (model == "rplidar_a3") s.baud = 256000, s.typical_mode = 2, s.rotor.farthest_m = 25.0;
  } else if (model == "rplidar_c1") {
    s.model = 0x41, s.baud = 460800;
    s.modes = {{"Standard", 0x81, 200.0}, {"DenseBoost", 0x85, 200.0}};
    s.rotor.turns_per_second = 10.0;
  } else if (model == "rplidar_s1" || model == "rplidar_s2") {
    s.model = model == "rplidar_s1" ? 0x61 : 0x71;
    s.motor = Motor::Speed;
    s.baud = model == "rplidar_s1" ? 256000 : 1000000;
    const double us = model == "rplidar_s1" ? 108.0 : 31.25;
    s.modes = {{"Standard", 0x81, model == "rplidar_s1" ? 216.0 : 100.0}, {"DenseBoost", 0x85, us}};
    s.rotor.turns_per_second = 10.0;
    s.rotor.farthest_m = 30.0;
  }
  s.rotor.points_per_second = 1e6 / s.modes[s.typical_mode].us_per_sample;
  return s;
}

Rplidar::Rplidar(Settings settings, Room room)
    : settings_(std::move(settings)), rotor_(settings_.rotor, std::move(room)) {
  // A board that takes a speed, or PWM, lets the motor stand until it gets one. A modem line that nobody drives lets it run.
  turn_motor(settings_.motor == Motor::ModemLine);
}

void Rplidar::turn_motor(bool on) {
  motor_turns_ = on;
  rotor_.aim_at(on ? settings_.rotor.turns_per_second : 0.0);
}

void Rplidar::set_data_terminal_ready(bool ready) {
  if (settings_.motor == Motor::ModemLine && motor_turns_ == ready) turn_motor(!ready);
}

void Rplidar::set_health(std::uint8_t status, std::uint16_t code, bool heals) {
  health_ = status;
  health_code_ = code;
  heals_ = heals;
}

void Rplidar::answer(std::uint8_t type, ByteView payload) {
  const Bytes descriptor = print_rplidar_descriptor(static_cast<std::uint32_t>(payload.size()), false, type);
  outbox_.insert(outbox_.end(), descriptor.begin(), descriptor.end());
  outbox_.insert(outbox_.end(), payload.begin(), payload.end());
}

void Rplidar::start(std::uint8_t answer, std::uint32_t packet_bytes) {
  const Bytes descriptor = print_rplidar_descriptor(packet_bytes, true, answer);
  outbox_.insert(outbox_.end(), descriptor.begin(), descriptor.end());
  stream_ = answer;
  first_ = true;
  points_.clear();
}

void Rplidar::receive(ByteView bytes, Duration now) {
  requests_.feed(bytes, [&](std::uint8_t command, ByteView payload) { on_request(command, payload, now); });
}

void Rplidar::on_request(std::uint8_t command, ByteView payload, Duration now) {
  if (now < deaf_until_) return;
  const auto microseconds = [&](std::size_t mode) {
    return static_cast<std::uint32_t>(
        std::lround(settings_.modes[std::min(mode, settings_.modes.size() - 1)].us_per_sample));
  };
  if (command == 0x25) {
    stream_ = 0;
  } else if (command == 0x40) {
    stream_ = 0;
    if (heals_) health_ = 0;
    deaf_until_ = now + 500ms;
    const ByteView text = as_bytes("RP LIDAR System.\r\nFirmware Ver 1.29, HW Ver 7\r\n");
    outbox_.assign(text.begin(), text.end());
  } else if (command == 0x50 && stream_ == 0) {
    Bytes info{settings_.model, static_cast<std::uint8_t>(settings_.firmware),
               static_cast<std::uint8_t>(settings_.firmware >> 8U), 7};
    for (std::uint8_t i = 0; i < 16; ++i) info.push_back(static_cast<std::uint8_t>(0xC0 + i));
    answer(0x04, info);
  } else if (command == 0x52 && stream_ == 0) {
    answer(0x06,
           Bytes{health_, static_cast<std::uint8_t>(health_code_), static_cast<std::uint8_t>(health_code_ >> 8U)});
  } else if (command == 0x59 && stream_ == 0) {
    Bytes rates = little_endian(microseconds(0), 2);
    const Bytes express = little_endian(microseconds(1), 2);
    rates.insert(rates.end(), express.begin(), express.end());
    answer(0x15, rates);
  } else if (command == 0x84 && stream_ == 0 && settings_.has_modes) {
    on_configuration(payload);
  } else if (command == 0xFF && stream_ == 0 && settings_.motor != Motor::ModemLine) {
    answer(0xFF, little_endian(settings_.motor == Motor::Pwm ? 1 : 0, 4));
  } else if (command == 0xF0 && payload.size() == 2 && settings_.motor == Motor::Pwm) {
    turn_motor(load_le16(payload.data()) > 0);
  } else if (command == 0xA8 && payload.size() == 2 && settings_.motor == Motor::Speed) {
    turn_motor(load_le16(payload.data()) > 0);
  } else if (health_ == 2) {
    return;  // it measures nothing
  } else if (command == 0x20 || command == 0x21) {
    rotor_.measure_at(1e6 / settings_.modes[0].us_per_sample);
    start(0x81, 5);
  } else if (command == 0x82 && payload.size() == 5) {
    const std::size_t mode = settings_.has_modes ? payload[0] : 1;
    // Mode 0 is that of the first devices with an express scan.
    rotor_.measure_at(1e6 / settings_.modes[std::min(mode, settings_.modes.size() - 1)].us_per_sample);
    const std::uint8_t type = mode == 0 || mode >= settings_.modes.size() ? 0x82 : settings_.modes[mode].answer;
    start(type, bytes_in(type));
  }
}

void Rplidar::on_configuration(ByteView payload) {
  if (payload.size() < 4) return;
  const std::uint8_t key = payload[0];
  const std::size_t asked = payload.size() >= 6 ? load_le16(payload.data() + 4) : 0;
  Bytes value = little_endian(key, 4);
  const auto add = [&](const Bytes& more) { value.insert(value.end(), more.begin(), more.end()); };
  if (key == 0x70) {
    add(little_endian(static_cast<std::uint32_t>(settings_.modes.size()), 2));
  } else if (key == 0x7C) {
    add(little_endian(static_cast<std::uint32_t>(settings_.typical_mode), 2));
  } else if (asked >= settings_.modes.size()) {
    return;
  } else if (key == 0x71) {
    add(little_endian(static_cast<std::uint32_t>(std::lround(settings_.modes[asked].us_per_sample * 256.0)), 4));
  } else if (key == 0x74) {
    add(little_endian(static_cast<std::uint32_t>(settings_.rotor.farthest_m * 256.0), 4));
  } else if (key == 0x75) {
    add({settings_.modes[asked].answer});
  } else if (key == 0x7F) {
    const ByteView name = as_bytes(settings_.modes[asked].name);
    value.insert(value.end(), name.begin(), name.end());
    value.push_back(0);
  } else {
    return;
  }
  answer(0x20, value);
}

void Rplidar::advance(Duration now, const Send& send) {
  if (!outbox_.empty()) send(now, std::exchange(outbox_, {}));
  while (rotor_.next_at() <= now) measure(send);
}

void Rplidar::measure(const Send& send) {
  const double rotor_deg = rotor_.next_angle_deg();
  double offset_deg = 0.0;
  if (triangulates(settings_.model)) {
    // Where it looks depends on the range that it finds there.
    for (int i = 0; i < 4; ++i)
      offset_deg = rplidar_offset_deg(std::min(rotor_.wall_m(rotor_deg - offset_deg), 30.0) * 1000.0);
    if (stream_ == 0x82) offset_deg = std::round(offset_deg * 8.0) / 8.0;
  }
  const LidarRotor::Sample sample = rotor_.next(offset_deg);
  if (stream_ == 0) return;
  const RplidarPoint point{rotor_deg, offset_deg, sample.range_m * 1000.0};
  if (stream_ == 0x81)
    return send(sample.at, print_rplidar_node(point, sample.starts_turn, sample.range_m > 0.0 ? 47 : 0));
  points_.push_back(point);
  const std::size_t count = points_in(stream_);
  // The last difference of an ultra capsule is to the point after it.
  if (points_.size() < count + (stream_ == 0x84 ? 1 : 0)) return;
  const bool first = std::exchange(first_, false);
  const std::span<const RplidarPoint> points{points_.data(), count};
  send(sample.at, stream_ == 0x82   ? print_rplidar_capsule(points, first)
                  : stream_ == 0x85 ? print_rplidar_dense_capsule(points, first)
                                    : print_rplidar_ultra_capsule(points, points_.back(), first));
  points_.erase(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace nacelle::simulation
