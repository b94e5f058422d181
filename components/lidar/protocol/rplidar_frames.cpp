// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/rplidar_frames.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::lidar {
namespace {

using namespace rplidar_layout;

float wrapped(double deg) {
  if (deg < 0.0) deg += 360.0;
  if (deg >= 360.0) deg -= 360.0;
  return static_cast<float>(deg);
}

/// A triangulating sensor looks past its axis: by 8 deg less the angle that 24.01 mm have at the range. Below 50 mm the SDK takes
/// 7.5 deg. Source: offsetAngleMean of the SDK's ultra capsules, in radians * 2^16: its integers are 98361 / range (1/4 mm).
double ultra_offset_deg(unsigned mm) {
  if (mm < 50) return 7.5;
  const double share = 98361.0 / 1024.0 / (4.0 * mm);
  return 8.0 - (share + share * share * share / 6.0) * 180.0 / std::numbers::pi;
}

std::size_t ultra_beams(ByteView packet, ByteView next, double first_deg, double step_deg,
                        std::span<Beam, kMostPoints> beams) {
  const std::uint8_t* const cabins = packet.data() + kCapsuleHeadBytes;
  for (std::size_t i = 0; i < 32; ++i) {
    const std::uint32_t cabin = load_le32(cabins + 4 * i);
    const std::uint32_t after = load_le32(i + 1 < 32 ? cabins + 4 * (i + 1) : next.data() + kCapsuleHeadBytes);
    const UltraRange major = ultra_range(cabin & 0xFFFU), major_after = ultra_range(after & 0xFFFU);
    // Ten-bit two's complements; the ends of the range mean that nothing came back.
    const int second = static_cast<int>((cabin >> 12U & 0x3FFU) ^ 0x200U) - 0x200;
    const int third = static_cast<int>((cabin >> 22U & 0x3FFU) ^ 0x200U) - 0x200;
    const UltraRange base = major.mm == 0 && major_after.mm != 0 ? major_after : major;
    const auto moved = [](int difference, UltraRange from) {
      if (difference == -512 || difference == 511) return 0U;
      const int mm = static_cast<int>(from.mm) + difference * (1 << from.shift);
      return mm > 0 ? static_cast<unsigned>(mm) : 0U;
    };
    const std::array ranges{major.mm, moved(second, base), moved(third, major_after)};
    for (std::size_t k = 0; k < 3; ++k) {
      const double rotor_deg = first_deg + static_cast<double>(3 * i + k) * step_deg;
      beams[3 * i + k] = {wrapped(std::fmod(rotor_deg, 360.0) - ultra_offset_deg(ranges[k])),
                          static_cast<float>(ranges[k]) / 1000.0F, 0.0F};
    }
  }
  return 96;
}

}  // namespace

bool is_rplidar_node(const std::uint8_t* bytes) {
  return ((bytes[0] ^ bytes[0] >> 1U) & 1U) == 1U && (bytes[1] & 1U) == 1U && node_angle_q6(bytes) < kTurn_q6;
}

bool is_rplidar_capsule(ByteView packet) {
  unsigned sum = 0;
  for (const std::uint8_t byte : packet.subspan(2)) sum ^= byte;
  return sum == ((packet[0] & 0x0FU) | (packet[1] & 0x0FU) << 4U);
}

UltraRange ultra_range(unsigned major) {
  // Segments of growing steps, as the SDK has them: first major, its range in mm, step as a power of two.
  if (major >= 3328) return {(1U << 14U) + ((major - 3328) << 4U), 4};
  if (major >= 1792) return {(1U << 12U) + ((major - 1792) << 3U), 3};
  if (major >= 1280) return {(1U << 11U) + ((major - 1280) << 2U), 2};
  if (major >= 512) return {(1U << 9U) + ((major - 512) << 1U), 1};
  return {major, 0};
}

std::size_t rplidar_beams(RplidarAnswer type, ByteView packet, ByteView next, double first_deg, double step_deg,
                          std::span<Beam, kMostPoints> beams) {
  if (type == RplidarAnswer::UltraCapsules) return ultra_beams(packet, next, first_deg, step_deg, beams);
  const std::uint8_t* const points = packet.data() + kCapsuleHeadBytes;
  const auto rotor_deg = [&](std::size_t i) { return std::fmod(first_deg + static_cast<double>(i) * step_deg, 360.0); };
  if (type == RplidarAnswer::DenseCapsules) {
    for (std::size_t i = 0; i < 40; ++i)
      beams[i] = {wrapped(rotor_deg(i)), static_cast<float>(load_le16(points + 2 * i)) / 1000.0F, 0.0F};
    return 40;
  }
  for (std::size_t i = 0; i < 32; ++i) {
    const std::uint8_t* const cabin = points + 5 * (i / 2);
    const unsigned point = load_le16(cabin + 2 * (i % 2));
    const unsigned low = i % 2 == 0 ? cabin[4] & 0x0FU : cabin[4] >> 4U;
    const unsigned offset_q3 = low | (point & 3U) << 4U;
    beams[i] = {wrapped(rotor_deg(i) - offset_q3 / 8.0), static_cast<float>(point >> 2U) / 1000.0F, 0.0F};
  }
  return 32;
}

}  // namespace nacelle::lidar
