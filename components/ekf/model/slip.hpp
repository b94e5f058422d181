// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "ekf/model/witness.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::ekf {

struct SlipOptions {
  bool on = false;
  double yaw_rate_rps = 0.15;       ///< Wheels and gyro may differ by so much, and by a tenth of the rate.
  double speed_mps = 0.15;          ///< Wheels and the integral of the accelerometer may differ by so much.
  double inflation = 10.0;          ///< The standard deviation that the wheels gain, as a multiple of the difference.
  double wheel_separation_m = 0.3;  ///< One wheel that slips by d changes the yaw rate by d over this.
  Duration longest = 3s;            ///< Wheels that differ for longer do not slip: the IMU is wrong.
};

/// How much less the wheels count, as variances to add.
struct Doubt {
  double speed_mps2{}, yaw_rate_rps2{};  ///< Squared: (m/s)^2, (rad/s)^2.
  [[nodiscard]] bool any() const { return speed_mps2 > 0.0 || yaw_rate_rps2 > 0.0; }
};

/// Compares the wheels with gyro and accelerometer.
///
/// Yaw rate: the difference of both. Speed: the accelerometer is integrated, and drawn to the wheels by an observer that learns
/// its offset (bias, tilt), but not while they slip. Wheels that turn steadily beside a force that a ramp explains do not begin
/// to slip: the observer then follows them fast. An IMU that often disagrees is not a witness: the time of disagreement
/// adds up, agreement takes a quarter of its time off. Above SlipOptions::longest no slip is seen until the sum is zero. It
/// begins above zero: an IMU that never agreed is not believed.
/// Threads: a value. Allocates: nothing.
struct Slip {
  WallTime last_imu{}, last_wheels{};
  WallTime differed{};     ///< The last time that armed witnesses differed.
  WallTime speed_since{};  ///< The speed differs since then; 0: it does not.
  double gyro_rps{};       ///< Smoothed, known bias taken off.
  double yaw_gap_rps{};    ///< Smoothed; wheels minus gyro.
  double speed_mps{};      ///< By accelerometer and, while they do not slip, wheels.
  double speed_gap_mps{};  ///< Wheels minus that.
  double force_mps2{};     ///< Smoothed, offset taken off.
  double offset_mps2{};    ///< Of the accelerometer.
  double wheels_mps{};     ///< The last speed of the wheels, and how it changes, smoothed:
  double wheels_mps2{};
  double disagreement_s{0.25};  ///< See the class.
  bool armed{}, slipping{}, distrusts_imu{}, has_force{};
  std::uint64_t episodes{}, inflated{}, distrusted{};

  void see_imu(WallTime stamp, const Witness& imu, double yaw_rate_rps);
  [[nodiscard]] Doubt see_wheels(WallTime stamp, const Witness& wheels, const SlipOptions& options);
  /// The clock was set: times mean nothing any more.
  void forget_times();

 private:
  void follow_wheels(double speed, double dt_s);
  void judge_witness(bool differs, double dt_s, const SlipOptions& options);
};

}  // namespace nacelle::ekf
