// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "nacelle/base/bytes.hpp"

namespace nacelle::lidar {

namespace ld06_layout {
// LD06, LD19, STL-19P (230400 8N1) and STL-27L (921600): 47 bytes, little-endian, sent without request.
// Source: ldrobotSensorTeam/ldlidar_stl_ros2, ldlidar_driver/src/dataprocess/lipkg.cpp (commit 258b933).
//
//   offset  bytes  field         on the wire                          becomes
//        0      1  start         0x54                                 -
//        1      1  version/size  low five bits: points, always 12     -
//        2      2  speed         deg/s                                speed_dps
//        4      2  first angle   0.01 deg                             first_angle_cdeg
//        6     36  12 points     uint16 mm, uint8 intensity           points
//       42      2  last angle    0.01 deg                             last_angle_cdeg
//       44      2  time          ms, restarts after 30000             device_time_ms
//       46      1  crc8          over bytes 0 to 45                   checked
inline constexpr std::size_t kStart = 0, kSize = 1, kSpeed = 2, kFirstAngle = 4, kPoints = 6, kLastAngle = 42,
                             kTime = 44, kCrc = 46, kFrameBytes = 47;
inline constexpr std::size_t kPointsPerFrame = 12, kPointBytes = 3;
inline constexpr std::uint8_t kStartByte = 0x54, kSizeByte = 0x2C;
static_assert(kPoints + kPointsPerFrame * kPointBytes == kLastAngle);
static_assert(kCrc + 1 == kFrameBytes);
}  // namespace ld06_layout

/// One measured direction, in the device's units.
struct Ld06Point {
  std::uint16_t range_mm{};  ///< 0: nothing came back.
  std::uint8_t intensity{};  ///< Device scale; compare only within one device.
  friend bool operator==(const Ld06Point&, const Ld06Point&) = default;
};

/// Twelve neighbouring directions. Angles are the device's: clockwise seen from above, 0 at its front mark.
struct Ld06Frame {
  std::uint16_t speed_dps{};
  std::uint16_t first_angle_cdeg{};  ///< 0.01 deg, 0 to 35999
  std::uint16_t last_angle_cdeg{};   ///< 0.01 deg, 0 to 35999
  std::uint16_t device_time_ms{};
  std::array<Ld06Point, ld06_layout::kPointsPerFrame> points{};

  /// Angle from the first to the last point, turning on over 360 deg. Units: 0.01 deg.
  [[nodiscard]] unsigned span_cdeg() const { return (last_angle_cdeg + 36000U - first_angle_cdeg) % 36000U; }
  /// Angle of point i. Units: 0.01 deg in [0, 36000).
  [[nodiscard]] double angle_cdeg(std::size_t i) const {
    const double angle = first_angle_cdeg + static_cast<double>(span_cdeg()) * static_cast<double>(i) /
                                                static_cast<double>(ld06_layout::kPointsPerFrame - 1);
    return angle < 36000.0 ? angle : angle - 36000.0;
  }
  friend bool operator==(const Ld06Frame&, const Ld06Frame&) = default;
};

/// CRC-8 with polynomial 0x4D, first value 0, most significant bit first, nothing reflected or inverted.
[[nodiscard]] std::uint8_t ld06_crc8(ByteView bytes);

}  // namespace nacelle::lidar
