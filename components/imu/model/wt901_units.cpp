// SPDX-License-Identifier: Apache-2.0
#include "imu/model/wt901_units.hpp"

#include <cmath>
#include <numbers>

namespace nacelle::imu {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

Vector3 scaled(const Wt901Frame& frame, double unit) {
  return {frame.values[0] * unit, frame.values[1] * unit, frame.values[2] * unit};
}

}  // namespace

Vector3 acceleration_mps2(const Wt901Frame& frame) { return scaled(frame, 16.0 * kGravityMps2 / 32768.0); }

Vector3 angular_velocity_rps(const Wt901Frame& frame) { return scaled(frame, 2000.0 * kRadPerDeg / 32768.0); }

Vector3 magnetic_field_t(const Wt901Frame& frame, double tesla_per_count) { return scaled(frame, tesla_per_count); }

Orientation orientation_from_angles(const Wt901Frame& frame) {
  const Vector3 angles = scaled(frame, 180.0 * kRadPerDeg / 32768.0);
  const double cr = std::cos(angles[0] / 2), sr = std::sin(angles[0] / 2);
  const double cp = std::cos(angles[1] / 2), sp = std::sin(angles[1] / 2);
  const double cy = std::cos(angles[2] / 2), sy = std::sin(angles[2] / 2);
  // q = q_yaw * q_pitch * q_roll
  return {cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr,
          sy * cp * cr - cy * sp * sr};
}

std::optional<Orientation> orientation_from_quaternion(const Wt901Frame& frame) {
  const double w = frame.values[0] / 32768.0, x = frame.values[1] / 32768.0;
  const double y = frame.values[2] / 32768.0, z = frame.values[3] / 32768.0;
  const double length = std::sqrt(w * w + x * x + y * y + z * z);
  // Four roundings of 1/65536 move the length by a few 1e-5; a tenth is a device that is still starting.
  if (std::abs(length - 1.0) > 0.1) return std::nullopt;
  return Orientation{w / length, x / length, y / length, z / length};
}

}  // namespace nacelle::imu
