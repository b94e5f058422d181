// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "lidar/protocol/sweep.hpp"
#include "nacelle/base/bytes.hpp"

namespace nacelle::lidar {

/// What an answer of an RPLIDAR is, by the last byte of its descriptor.
enum class RplidarAnswer : std::uint8_t {
  None = 0x00,           ///< Nothing is expected.
  Info = 0x04,           ///< 20 bytes: model, firmware minor and major, hardware, serial number of 16
  Health = 0x06,         ///< 3 bytes: status (0 good, 1 warning, 2 error), code u16
  SampleRate = 0x15,     ///< 4 bytes: microseconds of a sample u16, standard and express
  Configuration = 0x20,  ///< key u32, then the value
  BoardFlags = 0xFF,     ///< u32, bit 0: the board drives the motor by PWM
  Nodes = 0x81,          ///< endless, 5 bytes a point
  Capsules = 0x82,       ///< endless, 84 bytes, 32 points
  UltraCapsules = 0x84,  ///< endless, 132 bytes, 96 points
  DenseCapsules = 0x85   ///< endless, 84 bytes, 40 points
};
[[nodiscard]] constexpr bool is_stream(RplidarAnswer type) {
  return type == RplidarAnswer::Nodes || type == RplidarAnswer::Capsules || type == RplidarAnswer::UltraCapsules ||
         type == RplidarAnswer::DenseCapsules;
}
/// Bytes of one packet; 0 where the descriptor says it (Configuration) or nothing comes.
[[nodiscard]] constexpr std::size_t packet_bytes_of(RplidarAnswer type) {
  switch (type) {
    case RplidarAnswer::Info: return 20;
    case RplidarAnswer::Health: return 3;
    case RplidarAnswer::SampleRate:
    case RplidarAnswer::BoardFlags: return 4;
    case RplidarAnswer::Nodes: return 5;
    case RplidarAnswer::Capsules:
    case RplidarAnswer::DenseCapsules: return 84;
    case RplidarAnswer::UltraCapsules: return 132;
    case RplidarAnswer::None:
    case RplidarAnswer::Configuration: return 0;
  }
  return 0;
}
/// Points of one packet.
[[nodiscard]] constexpr std::size_t points_of(RplidarAnswer type) {
  return type == RplidarAnswer::Capsules        ? 32
         : type == RplidarAnswer::DenseCapsules ? 40
         : type == RplidarAnswer::UltraCapsules ? 96
                                                : 1;
}

namespace rplidar_layout {
// Source: Slamtec/rplidar_sdk, sdk/include/rplidar_cmd.h and sl_lidar_protocol.h (commit a7d0233); communication protocol
// LR001 of the maker, versions of 2018 and 2019. Little-endian.
//
//   descriptor   A5 5A, u32: 30 bits length and 2 bits mode (0 one answer, 1 endless), type
//   node         byte 0: bit 0 S (first of a turn), bit 1 not S, bits 2-7 quality; u16: bit 0 is 1, bits 1-15 angle, 1/64 deg;
//                u16 distance, 1/4 mm
//   capsules     byte 0: high nibble A, low nibble of the checksum; byte 1: high nibble 5, high nibble of the checksum;
//                u16: bit 15 first after a start, bits 0-14 start angle, 1/64 deg; then the points.
//                Checksum: exclusive or of all bytes from byte 2.
//     express    16 cabins of two points: u16 and u16 (bits 2-15 distance mm, bits 0-1 high bits of the angle offset), u8 (low
//                four bits of the two offsets, the first point's in the low nibble); offset in 1/8 deg
//     dense      40 points: u16 distance, mm
//     ultra      32 cabins of three points: u32: bits 0-11 major (scaled distance), bits 12-21 and 22-31 signed differences of
//                the second point to this major, of the third to the next one's
inline constexpr std::size_t kDescriptorBytes = 7, kNodeBytes = 5, kCapsuleHeadBytes = 4, kMostPacketBytes = 132,
                             kMostPoints = 96, kMostConfigurationBytes = 128;
inline constexpr std::uint8_t kRequest = 0xA5, kAnswer = 0x5A;
inline constexpr unsigned kTurn_q6 = 360 * 64;
}  // namespace rplidar_layout

[[nodiscard]] inline std::uint32_t load_le32(const std::uint8_t* at) {
  return static_cast<std::uint32_t>(load_le16(at)) | static_cast<std::uint32_t>(load_le16(at + 2)) << 16U;
}
/// True if five bytes may be a node: the check bits fit, and the angle is less than a turn.
[[nodiscard]] bool is_rplidar_node(const std::uint8_t* bytes);
/// Angle of a node. Units: 1/64 deg.
[[nodiscard]] inline unsigned node_angle_q6(const std::uint8_t* bytes) { return load_le16(bytes + 1) >> 1U; }
/// True if the checksum of a capsule is right.
[[nodiscard]] bool is_rplidar_capsule(ByteView packet);
/// Start angle of a capsule. Units: 1/64 deg.
[[nodiscard]] inline unsigned capsule_angle_q6(ByteView packet) { return load_le16(packet.data() + 2) & 0x7FFFU; }
[[nodiscard]] inline bool capsule_is_first(ByteView packet) { return (packet[3] & 0x80U) != 0; }

/// The range that a 12-bit major of an ultra capsule stands for, in mm, and by which power of two its differences count.
struct UltraRange {
  unsigned mm{}, shift{};
};
[[nodiscard]] UltraRange ultra_range(unsigned major);

/// Beams of a packet, the first at rotor angle `first_deg`, each `step_deg` after the one before. Returns how many.
/// The last beam of an ultra capsule needs the capsule after it.
std::size_t rplidar_beams(RplidarAnswer type, ByteView packet, ByteView next, double first_deg, double step_deg,
                          std::span<Beam, rplidar_layout::kMostPoints> beams);

}  // namespace nacelle::lidar
