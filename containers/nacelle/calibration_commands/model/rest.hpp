// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "imu/model/wt901_units.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::calibration {

using imu::Vector3;

/// Readings of an IMU that is held still, in its published frame.
struct RestReadings {
  std::vector<Vector3> rates_rps, accelerations_mps2;
};

/// Why readings do not count as readings at rest.
enum class RestFault : std::uint8_t {
  TooFew,   ///< Fewer than kLeastReadings.
  Moving,   ///< They scatter more than a sensor at rest does.
  Turning,  ///< The rates are steady, but too large for a bias.
};

inline constexpr std::size_t kLeastReadings = 20;
/// The scatter of a sensor at rest, of its worst axis, is below these. Units: rad/s, m/s^2.
inline constexpr double kMostRateScatter = 0.02, kMostAccelerationScatter = 0.3;
/// A bias is below this, 20 deg/s. Source: the zero-rate output of an MPU-6050 (PS-MPU-6000A, 6.1).
inline constexpr double kMostRate = 0.35;

/// Returns zeros of an empty list.
[[nodiscard]] Vector3 mean_of(const std::vector<Vector3>& readings);
/// Returns the standard deviation of the worst axis.
[[nodiscard]] double scatter_of(const std::vector<Vector3>& readings);
[[nodiscard]] Result<void, RestFault> check_rest(const RestReadings& readings);

/// The side of a sensor that points up.
struct Side {
  std::size_t index = 0;  ///< +x, -x, +y, -y, +z, -z.
  std::string name;       ///< "+x"
};
/// Returns the side of a sensor whose accelerometer reads this at rest: the axis that points up reads +g (REP 145).
[[nodiscard]] Side side_up(const Vector3& acceleration_mps2);

}  // namespace nacelle::calibration
