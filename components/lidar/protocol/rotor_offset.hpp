// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "lidar/protocol/sweep.hpp"

namespace nacelle::lidar {

/// How far behind its rotor a triangulating device looks, on average over many turns: a wall that comes near must not move the
/// stamps. Threads: one. Allocates: nothing.
class RotorOffset {
 public:
  /// `usual_deg` counts until the first sweep.
  explicit RotorOffset(double usual_deg) : offset_deg_(usual_deg) {}

  /// Takes the beams of a sweep, as Sweep has them.
  void learn(std::span<const Beam> beams, double first_rotor_deg, double rotor_step_deg) {
    double sum_deg = 0.0;
    for (std::size_t i = 0; i < beams.size(); ++i) {
      const double rotor_deg = first_rotor_deg + static_cast<double>(i) * rotor_step_deg;
      sum_deg += std::remainder(rotor_deg - static_cast<double>(beams[i].angle_deg), 360.0);
    }
    // 8 deg is what the makers' formulas have for a far wall.
    const double mean_deg = std::clamp(sum_deg / static_cast<double>(beams.size()), 0.0, 8.0);
    // At first the plain mean of all sweeps: one of them sees one wall only.
    count_ = std::min(count_ + 1, kSweeps);
    offset_deg_ += (mean_deg - offset_deg_) / count_;
  }
  /// The rotor's angle as that of a usual beam, in [0, 360).
  [[nodiscard]] double seen_from(double rotor_deg) const {
    const double seen_deg = rotor_deg < offset_deg_ ? rotor_deg - offset_deg_ + 360.0 : rotor_deg - offset_deg_;
    return seen_deg < 360.0 ? seen_deg : 0.0;  // a rounding
  }

 private:
  static constexpr int kSweeps = 1024;
  double offset_deg_;
  int count_ = 0;  ///< Sweeps so far, up to kSweeps.
};

}  // namespace nacelle::lidar
