// SPDX-License-Identifier: Apache-2.0
#include "ekf/model/wheeled_noise.hpp"

#include <algorithm>

namespace nacelle::ekf {
namespace {

// What wheels and a floor do not let happen happens to a tenth.
constexpr double kConstrained = 0.1 * 0.1;
// The matrix stays definite for states that have no noise of their own.
constexpr double kLeast = 1e-12;

}  // namespace

StateMatrix wheeled_process_noise(const VehicleLimits& limits) {
  const double tau = limits.interval_s;
  const double ramp_s = limits.speed_mps / limits.acceleration_mps2;
  const double yaw_acceleration =
      limits.yaw_acceleration_rps2 > 0.0 ? limits.yaw_acceleration_rps2 : limits.yaw_rate_rps / ramp_s;
  const double s2 = limits.acceleration_mps2 * limits.acceleration_mps2 / 3.0;
  const double turn_s2 = yaw_acceleration * yaw_acceleration / 3.0;
  const auto at_place = [tau](double variance) { return variance * tau * tau * tau / 4.0; };
  const auto at_rate = [tau](double variance) { return variance * tau; };

  StateVector q;
  q[kX] = q[kY] = at_place(s2);
  q[kYaw] = at_place(turn_s2);
  q[kVx] = at_rate(s2);
  q[kVyaw] = at_rate(turn_s2);
  q[kZ] = kConstrained * q[kX];
  q[kRoll] = q[kPitch] = kConstrained * q[kYaw];
  q[kVy] = q[kVz] = kConstrained * q[kVx];
  q[kVroll] = q[kVpitch] = kConstrained * q[kVyaw];
  q[kAx] = limits.measures_acceleration ? 2.0 * s2 / ramp_s : 0.0;
  q[kAy] = q[kAx];
  q[kAz] = kConstrained * q[kAx];
  const StateVector lifted = q.cwiseMax(kLeast);
  return lifted.asDiagonal();
}

}  // namespace nacelle::ekf
