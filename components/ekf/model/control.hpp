// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "ekf/model/state.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

/// How a commanded velocity becomes an acceleration that the prediction uses. Order everywhere: vx vy vz vroll vpitch vyaw.
///
/// Units:  SI; gains are 1/s.
/// Source: robot_localization's parameters control_config, control_timeout, acceleration_limits and so on.
struct ControlOptions {
  static constexpr std::size_t kAxes = 6;
  using Axes = std::array<double, kAxes>;

  std::array<bool, kAxes> controlled{};  ///< Which velocities are commanded.
  Duration timeout{};                    ///< A command that is this old counts as zero.
  Axes acceleration_limits{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  Axes acceleration_gains{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  Axes deceleration_limits{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
  Axes deceleration_gains{1.0, 1.0, 1.0, 1.0, 1.0, 1.0};

  [[nodiscard]] bool any() const {
    for (const bool axis : controlled) {
      if (axis) return true;
    }
    return false;
  }
};

/// The acceleration with which a commanded velocity is approached on one axis.
/// Threads: pure. Source: robot_localization, FilterBase::computeControlAcceleration.
[[nodiscard]] double control_acceleration(double velocity, double command, const ControlOptions& options,
                                          std::size_t axis);

/// Puts the accelerations of a command into a state that is about to be predicted dt_s on: linear ones become ax, ay, az,
/// angular ones change the rates at once.
/// Threads: pure. Source: robot_localization, Ekf::predict.
void apply_control(StateVector& state, const std::array<double, ControlOptions::kAxes>& command, double dt_s,
                   const ControlOptions& options);

}  // namespace nacelle::ekf
