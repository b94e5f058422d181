// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "simulation/model/lidar_rotor.hpp"
#include "simulation/model/serial_device.hpp"
#include "simulation/protocol/ydlidar_device.hpp"

namespace nacelle::simulation {

/// A YDLIDAR in the middle of a room. The X2 sends as long as it has power; the others are started and stopped.
class Ydlidar final : public SerialDevice {
 public:
  struct Settings {
    unsigned baud = 115200;
    bool is_commanded = false;
    bool has_intensities = false;
    bool says_speed = false;
    std::uint8_t model = 6;
    LidarRotor::Settings rotor{};
  };
  /// As sold: "ydlidar_x2", "ydlidar_x4", "ydlidar_g2", "ydlidar_g4", "ydlidar_g6".
  [[nodiscard]] static Settings settings_of(std::string_view model);

  Ydlidar(const Settings& settings, Room room);

  [[nodiscard]] unsigned baud() const override { return settings_.baud; }
  void receive(ByteView bytes, Duration now) override;
  void set_data_terminal_ready(bool ready) override;
  void advance(Duration now, const Send& send) override;

  void set_health(std::uint8_t status, std::uint16_t code) { health_ = {status, code}; }
  [[nodiscard]] LidarRotor& rotor() { return rotor_; }
  [[nodiscard]] bool is_scanning() const { return scans_; }
  [[nodiscard]] bool motor_turns() const { return motor_turns_; }

 private:
  void send_packet(Duration at, bool starts_turn, double turn_hz, const Send& send);

  const Settings settings_;
  LidarRotor rotor_;
  Bytes outbox_;
  bool awaits_command_ = false;  ///< The last byte was A5.
  bool scans_;
  bool motor_turns_ = true;
  std::pair<std::uint8_t, std::uint16_t> health_{};
  std::vector<YdlidarSample> samples_;
};

}  // namespace nacelle::simulation
