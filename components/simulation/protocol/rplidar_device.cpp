// SPDX-License-Identifier: Apache-2.0
#include "simulation/protocol/rplidar_device.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nacelle::simulation {
namespace {

unsigned angle_q6(double deg) {
  const double turned = std::fmod(deg + 720.0, 360.0);
  return static_cast<unsigned>(std::lround(turned * 64.0)) % (360 * 64);
}

void put16(Bytes& bytes, unsigned value) {
  bytes.push_back(static_cast<std::uint8_t>(value));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
}

Bytes begin_capsule(const RplidarPoint& start, bool first) {
  Bytes bytes{0xA0, 0x50};
  put16(bytes, angle_q6(start.rotor_deg) | (first ? 0x8000U : 0U));
  return bytes;
}

Bytes end_capsule(Bytes bytes) {
  std::uint8_t sum = 0;
  for (std::size_t i = 2; i < bytes.size(); ++i) sum = static_cast<std::uint8_t>(sum ^ bytes[i]);
  bytes[0] = static_cast<std::uint8_t>(bytes[0] | (sum & 0x0FU));
  bytes[1] = static_cast<std::uint8_t>(bytes[1] | sum >> 4U);
  return bytes;
}

/// One of the five scales of a major: ranges from `from_mm` on count in steps, from the code `from` on.
struct Scale {
  unsigned from_mm, step_mm, from;
};
constexpr std::array kScales{Scale{16384, 16, 3328}, Scale{4096, 8, 1792}, Scale{2048, 4, 1280}, Scale{512, 2, 512},
                             Scale{0, 1, 0}};

struct Major {
  unsigned code, stands_for_mm, step_mm;
};
Major major_of(double range_mm) {
  const auto mm = static_cast<unsigned>(std::lround(std::clamp(range_mm, 0.0, 28000.0)));
  for (const Scale& scale : kScales) {
    if (mm < scale.from_mm) continue;
    const unsigned steps = (mm - scale.from_mm) / scale.step_mm;
    return {scale.from + steps, scale.from_mm + steps * scale.step_mm, scale.step_mm};
  }
  return {0, 0, 1};
}

unsigned difference(double range_mm, const Major& base) {
  if (range_mm <= 0.0) return 0x200U;  // -512: nothing came back
  const long steps = std::lround((range_mm - base.stands_for_mm) / base.step_mm);
  return steps < -511 || steps > 510 ? 0x1FFU : static_cast<unsigned>(steps) & 0x3FFU;
}

}  // namespace

Bytes print_rplidar_descriptor(std::uint32_t length, bool endless, std::uint8_t type) {
  Bytes bytes{0xA5, 0x5A};
  put16(bytes, length & 0xFFFFU);
  put16(bytes, (length >> 16U & 0x3FFFU) | (endless ? 0x4000U : 0U));
  bytes.push_back(type);
  return bytes;
}

std::array<std::uint8_t, 5> print_rplidar_node(const RplidarPoint& point, bool starts_turn, unsigned quality) {
  std::array<std::uint8_t, 5> node{};
  node[0] = static_cast<std::uint8_t>(quality << 2U | (starts_turn ? 1U : 2U));
  store_le16(node.data() + 1, static_cast<std::uint16_t>(angle_q6(point.rotor_deg - point.offset_deg) << 1U | 1U));
  store_le16(node.data() + 3, static_cast<std::uint16_t>(std::lround(std::min(point.range_mm, 16383.0) * 4.0)));
  return node;
}

Bytes print_rplidar_capsule(std::span<const RplidarPoint> points, bool first) {
  Bytes bytes = begin_capsule(points[0], first);
  for (std::size_t i = 0; i < 32; i += 2) {
    std::array<unsigned, 2> offset{};
    for (std::size_t k = 0; k < 2; ++k) {
      const RplidarPoint& point = points[i + k];
      offset[k] = static_cast<unsigned>(std::lround(std::clamp(point.offset_deg, 0.0, 7.875) * 8.0));
      put16(bytes, static_cast<unsigned>(std::lround(std::min(point.range_mm, 16383.0))) << 2U | offset[k] >> 4U);
    }
    bytes.push_back(static_cast<std::uint8_t>((offset[0] & 0x0FU) | (offset[1] & 0x0FU) << 4U));
  }
  return end_capsule(std::move(bytes));
}

Bytes print_rplidar_dense_capsule(std::span<const RplidarPoint> points, bool first) {
  Bytes bytes = begin_capsule(points[0], first);
  for (std::size_t i = 0; i < 40; ++i)
    put16(bytes, static_cast<unsigned>(std::lround(std::min(points[i].range_mm, 65535.0))));
  return end_capsule(std::move(bytes));
}

Bytes print_rplidar_ultra_capsule(std::span<const RplidarPoint> points, const RplidarPoint& next, bool first) {
  Bytes bytes = begin_capsule(points[0], first);
  for (std::size_t i = 0; i < 96; i += 3) {
    const Major major = major_of(points[i].range_mm),
                after = major_of(i + 3 < 96 ? points[i + 3].range_mm : next.range_mm);
    // A point that did not come back lends no base to its neighbour.
    const Major base = major.code == 0 && after.code != 0 ? after : major;
    const unsigned cabin =
        major.code | difference(points[i + 1].range_mm, base) << 12U | difference(points[i + 2].range_mm, after) << 22U;
    put16(bytes, cabin & 0xFFFFU);
    put16(bytes, cabin >> 16U);
  }
  return end_capsule(std::move(bytes));
}

double rplidar_offset_deg(double range_mm) {
  if (range_mm < 50.0) return 7.5;
  return 8.0 - std::asin(98361.0 / 1024.0 / 4.0 / range_mm) * 180.0 / std::numbers::pi;
}

}  // namespace nacelle::simulation
