// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/rplidar_sweeps.hpp"

#include <cmath>
#include <cstdlib>

namespace nacelle::lidar {
namespace {

using namespace rplidar_layout;

constexpr double kFastest_dps = 360.0 * 100.0;  // as the SDK: no rotor turns faster

double ahead_of(double deg, double before_deg) {
  const double ahead = deg - before_deg;
  return ahead < 0.0 ? ahead + 360.0 : ahead;
}

/// How many packets of `each_deg` make `turned_deg`: those between were lost. A rotor that hardly turns says nothing.
std::int64_t packets_in(double turned_deg, double each_deg) {
  return each_deg > 1e-3 ? std::max<std::int64_t>(1, std::llround(turned_deg / each_deg)) : 1;
}

}  // namespace

void RplidarSweeps::take(const RplidarPacket& packet, std::size_t bytes_after, SweepSink& sink) {
  if (packet.type == RplidarAnswer::Nodes) {
    take_node(packet, bytes_after, sink);
  } else {
    take_capsule(packet, bytes_after, sink);
  }
}

void RplidarSweeps::take_node(const RplidarPacket& packet, std::size_t bytes_after, SweepSink& sink) {
  const double angle_deg = node_angle_q6(packet.bytes.data()) / 64.0;
  double turned_deg = has_sweep_ ? ahead_of(angle_deg, last_start_deg_) : 0.0;
  if (turned_deg > 180.0) turned_deg -= 360.0;
  // A single step is mostly correction; over 64 nodes that averages out.
  if (has_sweep_ && packet.follows())
    node_step_deg_ =
        node_step_deg_ == 0.0 ? std::max(turned_deg, 0.0) : node_step_deg_ + (turned_deg - node_step_deg_) / 64.0;
  std::int64_t steps = 1;
  if (!packet.follows()) {
    // What was skipped was nodes. If it was far less than the rotor turned, bytes were lost before they came.
    const std::int64_t by_angle = packets_in(turned_deg, node_step_deg_);
    steps = (static_cast<std::int64_t>(packet.skipped_bytes) + 5 + 2) / 5;
    if (std::abs(steps - by_angle) > 4) steps = by_angle;
  }
  beams_[0] = {static_cast<float>(angle_deg), static_cast<float>(load_le16(packet.bytes.data() + 3)) / 4000.0F,
               static_cast<float>(packet.bytes[0] >> 2U)};
  sink.on_sweep({.beams = std::span{beams_}.first(1),
                 .first_rotor_deg = angle_deg,
                 .period = period_,
                 .since_last = has_sweep_ ? steps * period_ : Duration{},
                 .packet_bytes = kNodeBytes,
                 .speed_dps = node_step_deg_ > 0.0 ? node_step_deg_ / to_seconds(period_) : 0.0,
                 .has_intensities = true},
                bytes_after);
  has_sweep_ = true;
  last_start_deg_ = angle_deg;
}

void RplidarSweeps::take_capsule(const RplidarPacket& packet, std::size_t bytes_after, SweepSink& sink) {
  const ByteView last{last_.data(), packet.bytes.size()};
  const auto points = static_cast<double>(points_of(packet.type));
  const Duration span = static_cast<std::int64_t>(points_of(packet.type)) * period_;
  if (capsule_is_first(packet.bytes)) restart();
  if (has_last_) {
    const double start_deg = capsule_angle_q6(last) / 64.0;
    const double turned_deg = ahead_of(capsule_angle_q6(packet.bytes) / 64.0, start_deg);
    if (packet.follows() && turned_deg < kFastest_dps * to_seconds(span)) {
      const std::size_t count = rplidar_beams(packet.type, last, packet.bytes, start_deg, turned_deg / points, beams_);
      offset_.learn(std::span{beams_}.first(count), start_deg, turned_deg / points);
      const std::int64_t packets = packets_in(ahead_of(start_deg, last_start_deg_), turned_deg);
      sink.on_sweep({.beams = std::span{beams_}.first(count),
                     .first_rotor_deg = offset_.seen_from(start_deg),
                     .rotor_step_deg = turned_deg / points,
                     .period = period_,
                     .since_last = has_sweep_ ? packets * span : Duration{},
                     .age = span,
                     .packet_bytes = packet.bytes.size(),
                     .speed_dps = turned_deg / to_seconds(span)},
                    bytes_after);
      has_sweep_ = true;
      last_start_deg_ = start_deg;
    } else {
      ++unpaired_;
    }
  }
  std::copy(packet.bytes.begin(), packet.bytes.end(), last_.begin());
  has_last_ = true;
}

}  // namespace nacelle::lidar
