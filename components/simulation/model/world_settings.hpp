// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace nacelle::simulation {

/// What the robot's maker says about it: the numbers that the motor board and the drivers believe.
struct RobotNominal {
  double wheel_radius_m = 0.033;
  double track_m = 0.30;
  int counts_per_turn = 1440;
  double body_radius_m = 0.16;          ///< Of the circle that may not enter a wall.
  double motor_time_constant_s = 0.05;  ///< Wheel speed reaches 63 % of a step in this time.
};

/// How far the real thing is from the nominal one: standard deviations of normal draws.
///
/// These are the defaults of `nacelle sim world`; the acceptance of the drive is measured in this world, so a test
/// pins them.
struct WorldErrors {
  double wheel_radius = 0.003;   ///< Of each wheel, relative; drawn once per seed.
  double track = 0.01;           ///< Relative; drawn once per seed.
  double slip = 0.005;           ///< Of each wheel, relative; drawn each second.
  double gyro_bias_dps = 0.1;    ///< Of each axis; drawn once per seed.
  double gyro_noise_dps = 0.1;   ///< Of each axis, rms per sample.
  double range_noise_m = 0.010;  ///< Of each LiDAR point.
  double accelerometer_noise_g = 0.002;
  double accelerometer_bias_g = 0.003;
  double magnetometer_noise_counts = 2.0;
  double heading_error_deg = 1.0;  ///< Amplitude of the magnetic heading's error over one turn; drawn once per seed.
};

/// The GPS receiver of the robot, and the place of the world on the Earth: its origin, x to the east, y to the north.
struct WorldGps {
  double latitude_deg = 49.8728, longitude_deg = 8.6512;
  double above_geoid_m = 144.0, geoid_m = 47.6;
  double rate_hz = 5.0;
  double error_m = 1.0;  ///< Of each position at HDOP 1, rms in each direction. 0.1 and less: a receiver with RTK.
  double hdop = 0.9, vdop = 1.4;
  double antenna_x_m = -0.1, antenna_y_m = 0.0, antenna_z_m = 0.15;  ///< On the base.
};

/// Errors that are chosen instead of drawn, for a test of what finds them. The draws stay the same beside them.
struct KnownErrors {
  /// Relative to the nominal length: 0.01 is one per cent more. Nothing: drawn.
  std::optional<double> left_radius, right_radius, track;
  double imu_yaw_rad = 0.0;             ///< The IMU's axes are turned by so much in the base.
  double imu_x_m = 0.0, imu_y_m = 0.0;  ///< The IMU is there, as seen from the middle of the axle.
};

/// All settings of a world.
struct WorldSettings {
  std::uint64_t seed = 1;
  RobotNominal robot{};
  WorldErrors errors{};
  WorldGps gps{};
  KnownErrors known{};
};

}  // namespace nacelle::simulation
