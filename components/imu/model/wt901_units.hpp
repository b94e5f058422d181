// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "imu/protocol/wt901_frame.hpp"

namespace nacelle::imu {

/// Three components along the sensor's axes x, y, z.
using Vector3 = std::array<double, 3>;

/// A unit quaternion, scalar first as the device sends it.
struct Orientation {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
};

/// Standard gravity: what the device's "g" means. Source: CGPM 1901.
inline constexpr double kGravityMps2 = 9.80665;

/// Acceleration in m/s^2, gravity included: +9.81 on z at rest (REP 145).
[[nodiscard]] Vector3 acceleration_mps2(const Wt901Frame& frame);
/// Angular velocity in rad/s.
[[nodiscard]] Vector3 angular_velocity_rps(const Wt901Frame& frame);
/// Magnetic field in tesla; the size of a count depends on the model.
[[nodiscard]] Vector3 magnetic_field_t(const Wt901Frame& frame, double tesla_per_count);
/// Orientation in ENU from a frame of roll, pitch and yaw (rotations about fixed x, y, z in this order; REP 103).
[[nodiscard]] Orientation orientation_from_angles(const Wt901Frame& frame);
/// Orientation in ENU from a quaternion frame, normalised; nothing if its length is far from one.
[[nodiscard]] std::optional<Orientation> orientation_from_quaternion(const Wt901Frame& frame);

}  // namespace nacelle::imu
