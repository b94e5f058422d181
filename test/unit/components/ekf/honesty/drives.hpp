// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "odometry/model/slip_model.hpp"

namespace nacelle::ekf::honesty {

/// Where the base really is.
struct TruePose {
  double t_s{}, x_m{}, y_m{}, yaw_rad{};  ///< The yaw is not wrapped.
};

/// One step of the wheels, at its end.
struct WheelReading {
  double t_s{}, dt_s{};
  odometry::WheelStep step;
};
/// A gyro's yaw rate.
struct GyroReading {
  double t_s{}, yaw_rate_rps{};
};

/// A drive: what the sensors said, and what was true.
struct Drive {
  std::string name;
  double separation_m{};
  std::vector<TruePose> truth;       ///< By time.
  std::vector<WheelReading> wheels;  ///< By time.
  std::vector<GyroReading> gyro;     ///< By time; empty: the wheels' turn is all there is.

  /// The truth at a time between two of its poses. Nothing outside.
  [[nodiscard]] std::optional<TruePose> true_pose(double t_s) const;
};

struct SimulatedDrive {
  std::uint64_t seed = 1;
  double seconds = 120.0;
  bool calibrates_gyro = true;  ///< Subtract the mean of the first second at rest, as the IMU's component does.
};
/// The simulated world's robot (simulation/model), with its defaults of slip, wheel, gyro bias and noise, in a room without walls:
/// 50 Hz of wheels in counts of its encoders, 100 Hz of gyro. It accelerates by at most 1 m/s^2 and 4 rad/s^2.
[[nodiscard]] Drive simulated(const SimulatedDrive& how);

/// A recorded drive: `odometry.csv` (t_s, distance_m, and the turn in the column `turn`) and `truth.csv` (t_s, x_m, y_m, yaw_rad).
[[nodiscard]] Drive recorded(const std::string& folder, const std::string& turn);

}  // namespace nacelle::ekf::honesty
