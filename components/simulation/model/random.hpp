// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace nacelle::simulation {

/// Draws that are the same on every machine for one seed.
///
/// Each device has a stream of its own, so that a lost range does not change the next slip. The normal transform is
/// our own: std::normal_distribution may differ between versions of the standard library, std::mt19937_64 may not.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t stream) : engine_(mixed(seed * 0x9E3779B97F4A7C15ULL + stream + 1)) {}

  /// In [0, 1), 53 bits.
  double uniform() { return static_cast<double>(engine_() >> 11U) * 0x1.0p-53; }
  /// Mean 0, the given standard deviation. Source: Box and Muller 1958; both values of a pair are used.
  double normal(double stddev = 1.0) {
    if (has_spare_) {
      has_spare_ = false;
      return spare_ * stddev;
    }
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    const double angle = 2.0 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle) * stddev;
  }

 private:
  // Neighbouring seeds must not give neighbouring engines. Source: splitmix64, Steele, Lea and Flood 2014.
  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace nacelle::simulation
