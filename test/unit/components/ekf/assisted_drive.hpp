// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

#include "ekf/model/filter.hpp"

namespace nacelle::ekf {

/// Seeded drives of a robot with two wheels, an IMU and errors that the filter is not told, for figures of the assists.
///
/// The IMU measures 100 times a second, the wheels 50 times, the filter steps 50 times. two_d_mode, default process noise.

/// What happens to the robot beside its command.
struct Upset {
  double wheel_speed{}, wheel_yaw_rate{};  ///< The wheels turn so much more than the body moves.
  double body_speed{}, body_yaw_rate{};    ///< The body moves so much while the wheels do not see it.
  double tilt_rad{};                       ///< Nose up: gravity in the accelerometer that nothing takes off.
};

struct DriveCase {
  double duration_s = 120.0;
  std::function<std::array<double, 2>(double t_s)> command;  ///< Speed and yaw rate to aim at.
  std::function<Upset(double t_s)> upset = [](double) { return Upset{}; };
  double gyro_bias_stddev_rps = 0.01;  ///< Drawn once.
  double gyro_bias_rps = 0.0;          ///< Added to it.
  double gyro_scale = 1.0;
  double gyro_noise_rps = 0.0017;
  double separation_error = 0.0;          ///< The wheels' yaw rate is so much too large, relative.
  double separation_error_stddev = 0.01;  ///< Drawn once, added.
  bool wheels_yaw_rate = false;           ///< Fuse it.
  bool acceleration = false;              ///< Fuse ax.
  bool wheels_teach_bias = false;
};

struct DriveResult {
  double yaw_rms_deg{}, position_rms_m{}, yaw_end_deg{};
  double bias_error_rps{};
  AssistState state;
};

/// One drive. The same seed, case and options give the same result.
[[nodiscard]] DriveResult drive(const DriveCase& how, const AssistOptions& assists, std::uint64_t seed);

/// The root mean square over so many seeds, from 1; the state is the last one's.
inline constexpr std::uint64_t kSeeds = 11;
[[nodiscard]] DriveResult drive_all_seeds(const DriveCase& how, const AssistOptions& assists);

}  // namespace nacelle::ekf
