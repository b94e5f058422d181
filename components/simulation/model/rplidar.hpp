// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "simulation/model/lidar_rotor.hpp"
#include "simulation/model/serial_device.hpp"
#include "simulation/protocol/rplidar_device.hpp"

namespace nacelle::simulation {

/// An RPLIDAR in the middle of a room: answers its host, and measures while it is commanded to and its motor turns.
class Rplidar final : public SerialDevice {
 public:
  struct Mode {
    std::string name;
    std::uint8_t answer;  ///< 81, 82, 84 or 85 (hexadecimal)
    double us_per_sample;
  };
  enum class Motor : std::uint8_t { ModemLine, Pwm, Speed };
  struct Settings {
    unsigned baud = 115200;
    std::uint8_t model = 0x18;
    std::uint16_t firmware = 0x011D;
    Motor motor = Motor::ModemLine;
    bool has_modes = true;  ///< False: old firmware, which does not answer GET_LIDAR_CONF.
    std::size_t typical_mode = 0;
    std::vector<Mode> modes;
    LidarRotor::Settings rotor{};  ///< points_per_second is the typical mode's.
  };

  /// As sold: "rplidar_a1", "rplidar_a2", "rplidar_a3", "rplidar_c1", "rplidar_s1", "rplidar_s2".
  [[nodiscard]] static Settings settings_of(std::string_view model);

  Rplidar(Settings settings, Room room);

  [[nodiscard]] unsigned baud() const override { return settings_.baud; }
  void receive(ByteView bytes, Duration now) override;
  void set_data_terminal_ready(bool ready) override;
  void advance(Duration now, const Send& send) override;

  /// From now on it says this about itself; a reset makes it healthy again if `heals`.
  void set_health(std::uint8_t status, std::uint16_t code, bool heals);
  [[nodiscard]] LidarRotor& rotor() { return rotor_; }
  [[nodiscard]] bool is_scanning() const { return stream_ != 0; }
  [[nodiscard]] bool motor_turns() const { return motor_turns_; }
  [[nodiscard]] const RplidarRequests::Stats& requests() const { return requests_.stats(); }

 private:
  void answer(std::uint8_t type, ByteView payload);
  void on_request(std::uint8_t command, ByteView payload, Duration now);
  void on_configuration(ByteView payload);
  void start(std::uint8_t answer, std::uint32_t packet_bytes);
  void measure(const Send& send);
  void turn_motor(bool on);

  const Settings settings_;
  LidarRotor rotor_;
  RplidarRequests requests_;
  Bytes outbox_;
  std::uint8_t stream_ = 0;  ///< 0: none
  bool first_ = false;
  bool motor_turns_ = true;
  Duration deaf_until_{};
  std::uint8_t health_ = 0;
  std::uint16_t health_code_ = 0;
  bool heals_ = false;
  std::vector<RplidarPoint> points_;
};

}  // namespace nacelle::simulation
