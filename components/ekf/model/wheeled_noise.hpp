// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/model/state.hpp"

namespace nacelle::ekf {

/// What a wheeled vehicle can do, as its maker or its base's configuration says.
struct VehicleLimits {
  double speed_mps = 1.0;
  double acceleration_mps2 = 1.0;
  double yaw_rate_rps = 2.0;
  double yaw_acceleration_rps2 = 0.0;  ///< 0: reaches its yaw rate in the time in which it reaches its speed.
  double interval_s = 1.0 / 30.0;      ///< Between two measurements of the velocity. Must be positive.
  bool measures_acceleration = false;  ///< ax is measured: it changes as the driver wills.
};

/// The process noise of a vehicle on wheels, per second, from its limits.
///
/// Between two updates, tau apart, the acceleration is constant and unknown: anywhere within +-a, so its variance is
/// s^2 = a^2 / 3. It moves the velocity by s tau and the position by s tau^2 / 2 in one interval; there are 1/tau of them per
/// second:
///
///   position, m^2/s         s^2 tau^3 / 4      yaw, rad^2/s            the same of the yaw acceleration
///   velocity, (m/s)^2/s     s^2 tau            yaw rate, (rad/s)^2/s   the same
///
/// The correlation of both (s^2 tau^2 / 2) is left out: it turns with the vehicle, and without it the uncertainty is larger. x and
/// y have the same noise, for what moves a vehicle sideways (v times the yaw rate) is of the order of its acceleration. A floor
/// lets the rest (vy, z, roll, pitch and their rates) do a tenth of that. ax is no motion of its own but what is left of the last
/// measurement: if it is measured, it changes by 2 s^2 / t per second (Singer), t = speed / acceleration; else it stays at zero.
///
/// Units:     SI.
/// Threads:   pure. Allocates: nothing.
/// Source:    Bar-Shalom, Li, Kirubarajan (2001), section 6.3.2 (discrete white noise acceleration model) and 8.2 (Singer's
///            model); a uniform distribution within +-a has the variance a^2 / 3.
[[nodiscard]] StateMatrix wheeled_process_noise(const VehicleLimits& limits);

}  // namespace nacelle::ekf
