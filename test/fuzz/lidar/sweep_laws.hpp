// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdlib>
#include <vector>

#include "lidar/model/scan_assembler.hpp"
#include "lidar/protocol/lidar_protocol.hpp"

namespace nacelle::lidar {

inline void require(bool holds) {
  if (!holds) std::abort();
}

/// Holds what every sweep promises, and assembles it, whatever bytes it was made of.
class SweepLaws final : public SweepSink {
 public:
  void on_sweep(const Sweep& sweep, std::size_t) override {
    require(!sweep.beams.empty());
    require(sweep.first_rotor_deg >= 0.0 && sweep.first_rotor_deg < 360.0);
    require(sweep.rotor_step_deg >= 0.0 && sweep.rotor_step_deg * static_cast<double>(sweep.beams.size() - 1) <= 360.0);
    require(sweep.since_last >= Duration{} && sweep.age >= Duration{});
    require(std::isfinite(sweep.speed_dps));
    for (const Beam& beam : sweep.beams) {
      require(beam.angle_deg >= 0.0F && beam.angle_deg <= 360.0F);
      require(beam.range_m >= 0.0F && beam.range_m < 66.0F);
    }
    beams.insert(beams.end(), sweep.beams.begin(), sweep.beams.end());
    now_ += sweep.since_last;
    assembler_.add(sweep, now_, [](const Scan& scan) {
      require(scan.ranges_m.size() == 450 && scan.intensities.size() == 450);
      for (const float range : scan.ranges_m)
        require(std::isnan(range) || std::isinf(range) || (range >= 0.0199F && range <= 12.001F));
    });
    require(assembler_.stats().points == beams.size());
  }
  std::vector<Beam> beams;

 private:
  ScanAssembler assembler_{{}};
  MonotonicTime now_{};
};

/// Feeds bytes at once and in parts that depend on them: nothing differs, and every byte is accounted for.
template <typename Make>
void hold_the_laws_of_bytes(ByteView bytes, Make&& make) {
  SweepLaws whole, chopped;
  const auto at_once = make();
  at_once->feed(bytes, whole);
  const auto in_parts = make();
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t part = std::min<std::size_t>(bytes.size() - at, 1 + bytes[at] % 61U);
    in_parts->feed(bytes.subspan(at, part), chopped);
    at += part;
  }
  require(at_once->stats() == in_parts->stats());
  require(whole.beams == chopped.beams);
  for (const auto* const protocol : {at_once.get(), in_parts.get()}) {
    const LineStats s = protocol->stats();
    require(s.bytes == bytes.size());
    require(s.bytes == s.framed_bytes + s.skipped_bytes + protocol->pending());
  }
  in_parts->restart();
  require(in_parts->pending() == 0);
}

}  // namespace nacelle::lidar
