// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace nacelle::ekf {

/// What a message says beyond what is fused of it, for the assists, along the axes of B.
struct Witness {
  enum class Source : std::uint8_t {
    None,    ///< Of no interest.
    Wheels,  ///< Velocities of the base as the wheels have it: m/s, rad/s.
    Imu      ///< Specific force (gravity included, m/s^2) and rates as they were measured (rad/s).
  };
  Source source{Source::None};
  bool has_force{true};     ///< Of Imu: `linear` was measured.
  bool teaches_bias{true};  ///< False of wheels: a wrong wheel separation is no bias of the gyro.
  std::array<double, 3> linear{}, angular{};
};

}  // namespace nacelle::ekf
