// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "nacelle/base/bytes.hpp"

namespace nacelle::simulation {

/// What a YDLIDAR measured before it packs it.
struct YdlidarSample {
  double rotor_deg{};    ///< Clockwise, not corrected.
  double range_mm{};     ///< 0: nothing came back.
  unsigned intensity{};  ///< 10 bits
};

/// A packet, from the device's side on purpose: the driver's decoder is another reading of the same description.
/// `turn_hz`: in the first packet of a turn, the speed that it tells; 0: none. At most 255 samples.
/// Source: YDLIDAR/YDLidar-SDK, doc/YDLidar-SDK-Communication-Protocol.md (commit 14f2cb1).
[[nodiscard]] Bytes print_ydlidar(std::span<const YdlidarSample> samples, bool starts_turn, double turn_hz,
                                  bool with_intensities);
/// How far before the rotor's angle the light goes, at a range.
[[nodiscard]] double ydlidar_offset_deg(double range_mm);

}  // namespace nacelle::simulation
