// SPDX-License-Identifier: Apache-2.0
#include "lidar/protocol/ld_protocol.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::lidar {
namespace {

/// Longer silences of the counter are no packets that were lost on the way.
constexpr unsigned kLongestGap_ms = 1000;

}  // namespace

Duration LdClock::step(const Ld06Frame& frame) {
  const unsigned ms = frame.device_time_ms % kTurnover_ms;
  const unsigned elapsed_ms = (ms + kTurnover_ms - last_ms_) % kTurnover_ms;
  const double packet_cdeg = frame.span_cdeg() * 12.0 / 11.0;
  const double turned_cdeg = (frame.last_angle_cdeg + 36000U - last_angle_cdeg_) % 36000U;
  const bool follows = std::exchange(started_, true) && elapsed_ms <= kLongestGap_ms;
  last_ms_ = ms;
  last_angle_cdeg_ = frame.last_angle_cdeg;
  if (!follows) {
    within_ms_ = 500us;
    return {};
  }
  // The angle tells how many packets were sent since, up to whole turns, which the counter tells apart.
  double packets = 1.0;
  if (packet_cdeg > 0.0) {
    packets = turned_cdeg / packet_cdeg;
    const double per_turn = 36000.0 / packet_cdeg;
    const double in_time = elapsed_ms * 1e-3 / to_seconds(packet_period_);
    if (in_time > packets + per_turn / 2) packets += per_turn * std::nearbyint((in_time - packets) / per_turn);
    packets = std::max(1.0, std::nearbyint(packets));
  }
  const Duration elapsed = std::chrono::milliseconds{elapsed_ms};
  const Duration expected =
      within_ms_ + Duration{static_cast<std::int64_t>(packets) * packet_period_.count()} - elapsed;
  const Duration settled = std::clamp(expected, Duration{}, Duration{1ms} - Duration{1});
  return elapsed + settled - std::exchange(within_ms_, settled);
}

LdProtocol::LdProtocol(unsigned points_per_second)
    : period_(Duration{1'000'000'000LL / static_cast<std::int64_t>(points_per_second)}),
      decoder_(points_per_second),
      clock_(points_per_second) {}

void LdProtocol::feed(ByteView bytes, SweepSink& sink) {
  decoder_.feed(bytes, [&](const Ld06Frame& frame, std::size_t bytes_after) {
    const float first_deg = static_cast<float>(frame.first_angle_cdeg) / 100.0F;
    const float step_deg = static_cast<float>(frame.span_cdeg()) / (100.0F * (ld06_layout::kPointsPerFrame - 1));
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      const float angle_deg = first_deg + static_cast<float>(i) * step_deg;
      beams_[i] = {angle_deg < 360.0F ? angle_deg : angle_deg - 360.0F,
                   static_cast<float>(frame.points[i].range_mm) / 1000.0F,
                   static_cast<float>(frame.points[i].intensity)};
    }
    sink.on_sweep({.beams = beams_,
                   .first_rotor_deg = frame.first_angle_cdeg / 100.0,
                   .rotor_step_deg = frame.span_cdeg() / (100.0 * (ld06_layout::kPointsPerFrame - 1)),
                   .period = period_,
                   .since_last = clock_.step(frame),
                   .packet_bytes = ld06_layout::kFrameBytes,
                   .speed_dps = static_cast<double>(frame.speed_dps),
                   .has_intensities = true},
                  bytes_after);
  });
}

void LdProtocol::restart() {
  decoder_.restart();
  clock_.restart();
}

LineStats LdProtocol::stats() const {
  const auto& line = decoder_.stats();
  return {.bytes = line.bytes,
          .frames = line.frames,
          .framed_bytes = ld06_layout::kFrameBytes * (line.frames + line.implausible),
          .implausible = line.implausible,
          .bad_checksums = line.bad_checksums,
          .skipped_bytes = line.skipped_bytes};
}

}  // namespace nacelle::lidar
