// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// What an LD06 measured before it sends a packet. Written from the device's side on purpose: the driver's decoder is
/// another reading of the same description, and the two meet in a test.
struct Ld06Packet {
  struct Point {
    std::uint16_t range_mm{};  ///< 0: no return
    std::uint8_t intensity{};
  };
  std::uint16_t speed_dps{};
  std::uint16_t start_cdeg{};  ///< Angle of the first point, 0.01 deg clockwise
  std::uint16_t end_cdeg{};    ///< Angle of the twelfth
  std::uint16_t time_ms{};     ///< Counts to 30000
  std::array<Point, 12> points{};
};

/// The 47 bytes of a packet.
/// Source: LD06 packet as in ldrobotSensorTeam/ldlidar_stl_ros2 (lipkg.cpp, commit 258b933); CRC-8 polynomial 0x4D.
[[nodiscard]] std::array<std::uint8_t, 47> print_ld06(const Ld06Packet& packet);

}  // namespace nacelle::simulation
