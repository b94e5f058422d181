// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "ekf/model/update.hpp"
#include "ekf/model/witness.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

struct StandstillOptions {
  bool on = false;
  bool two_d = false;               ///< vz, vroll and vpitch are held at 0 already.
  Duration time = 500ms;            ///< So long the wheels stand and the IMU is quiet before it counts.
  double speed_mps = 0.002;         ///< Wheels that are slower stand.
  double yaw_rate_rps = 0.005;      ///< The same of their yaw rate.
  double gyro_limit_rps = 0.05;     ///< A yaw rate that is larger, its known bias taken off, is motion.
  double gyro_change_rps = 0.004;   ///< A rate that differs by more from its mean since the wheels stand is motion.
  double force_change_mps2 = 0.3;   ///< The same of the accelerometer.
  double speed_stddev_mps = 0.002;  ///< Of the zero that is fused.
  double yaw_rate_stddev_rps = 0.002;
};

/// Decides from wheels and IMU whether the robot stands. Wheels that stand while the IMU shows motion (pushed, lifted, turned by
/// hand) are no standstill, and then none follows until the wheels have moved or the IMU reads what it read before.
/// Threads: a value. Allocates: nothing.
struct Standstill {
  WallTime still_since{};  ///< The wheels; 0: they turn.
  WallTime moved{};        ///< The IMU, since the wheels stand.
  WallTime last_imu{}, last_wheels{};
  Eigen::Vector3d rate = Eigen::Vector3d::Zero(), rate_at_rest = Eigen::Vector3d::Zero();
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), force_at_rest = Eigen::Vector3d::Zero();
  bool standing{}, contradicted{};
  std::uint64_t updates{};         ///< Zeros that were fused.
  std::uint64_t contradictions{};  ///< How often the IMU moved while the wheels stood.

  /// `yaw_bias_rps` is what is known of the gyro's, with its standard deviation; negative: nothing is known.
  void see_imu(WallTime stamp, const Witness& imu, double yaw_bias_rps, double bias_stddev_rps,
               const StandstillOptions& options);
  void see_wheels(WallTime stamp, const Witness& wheels, const StandstillOptions& options);
  /// The clock was set: times mean nothing any more.
  void forget_times();
};

/// Velocities of zero.
void write_zero_velocity(const StandstillOptions& options, Reading& out);

}  // namespace nacelle::ekf
