// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "imu_filter/model/orientation_filter.hpp"

namespace nacelle::imu_filter {

/// Turns with the gyro, and takes a share of the tilt and of the heading that accelerometer and magnetometer show.
///
/// Tilt and heading are corrected apart, so that a bent field cannot tilt the estimate. While the sensor is at rest the
/// gyro's bias is learnt.
/// Source: R. Valenti, I. Dryanovski, J. Xiao, "Keeping a Good Attitude" (Sensors 2015, 15, 19302), sections 5 and 5.3;
///         slerp throughout instead of the switch between lerp and slerp.
class ComplementaryFilter final : public OrientationFilter {
 public:
  struct Settings {
    double gain_acc = 0.01;  ///< Share of the tilt that one measurement mends.
    double gain_mag = 0.01;  ///< Share of the heading.
    bool do_bias_estimation = true;
    double bias_alpha = 0.01;      ///< Share of the gyro's reading at rest that goes into the bias.
    bool do_adaptive_gain = true;  ///< Trust the accelerometer less while the sensor accelerates.
  };
  ComplementaryFilter(const WorldFrame& world, const Settings& settings)
      : OrientationFilter(world), settings_(settings) {}

  // What counts as rest: acceleration within 0.1 m/s^2 of gravity, the gyro within 0.2 rad/s of its bias and within
  // 0.01 rad/s of where it was when rest began, all this for half a second. (imu_tools takes single readings: a smooth turn
  // then passes for a bias.)
  static constexpr double kRestAcceleration = 0.1, kRestRate = 0.2, kRestRateChange = 0.01, kRestTime = 0.5;

 private:
  void correct(const Measurement& measurement) override;
  [[nodiscard]] bool is_at_rest(const Measurement& measurement);

  const Settings settings_;
  Eigen::Vector3d resting_rps_{Eigen::Vector3d::Zero()};  ///< The gyro when rest began.
  double rested_s_ = 0.0;
};

}  // namespace nacelle::imu_filter
