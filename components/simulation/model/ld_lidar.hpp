// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "simulation/model/lidar_rotor.hpp"
#include "simulation/model/serial_device.hpp"
#include "simulation/protocol/ld06_encoder.hpp"

namespace nacelle::simulation {

/// An LD06, LD19, STL-19P or STL-27L: a packet for each twelve points, as long as it has power.
class LdLidar final : public SerialDevice {
 public:
  LdLidar(unsigned baud, const LidarRotor::Settings& settings, Room room)
      : baud_(baud), rotor_(settings, std::move(room)) {}

  [[nodiscard]] unsigned baud() const override { return baud_; }
  void advance(Duration now, const Send& send) override {
    while (rotor_.next_at() <= now) {
      const LidarRotor::Sample sample = rotor_.next();
      const auto angle_cdeg = static_cast<std::uint16_t>(std::lround(sample.angle_deg * 100.0) % 36000);
      auto& point = packet_.points[slot_];
      point = {};
      if (sample.range_m > 0.0) {
        point.range_mm = static_cast<std::uint16_t>(std::lround(sample.range_m * 1000.0));
        point.intensity = static_cast<std::uint8_t>(std::clamp(230.0 - 10.0 * sample.range_m, 20.0, 230.0));
      }
      if (slot_ == 0) packet_.start_cdeg = angle_cdeg;
      if (++slot_ < packet_.points.size()) continue;
      slot_ = 0;
      packet_.end_cdeg = angle_cdeg;
      packet_.speed_dps = static_cast<std::uint16_t>(std::lround(sample.speed_dps));
      packet_.time_ms = static_cast<std::uint16_t>(std::fmod(sample.device_time_s * 1000.0, 30000.0));
      send(sample.at, print_ld06(packet_));
    }
  }
  [[nodiscard]] LidarRotor& rotor() { return rotor_; }

 private:
  const unsigned baud_;
  LidarRotor rotor_;
  Ld06Packet packet_;
  std::size_t slot_ = 0;
};

}  // namespace nacelle::simulation
