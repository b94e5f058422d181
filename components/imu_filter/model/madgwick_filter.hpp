// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "imu_filter/model/orientation_filter.hpp"

namespace nacelle::imu_filter {

/// Gradient descent towards the measured directions of gravity and field, at a fixed speed.
///
/// The orientation turns with the gyro, and by at most `gain` against the gradient of the squared distance between the
/// measured and the expected directions. The field's inclination is taken from the measurement, so that a field that is bent
/// upright does not tilt the estimate.
/// Source: S. Madgwick, "An efficient orientation filter for inertial and inertial/magnetic sensor arrays" (2010),
///         equations 20 to 49. Here the gyro's part is the exact exponential instead of the first order.
class MadgwickFilter final : public OrientationFilter {
 public:
  struct Settings {
    double gain = 0.1;  ///< rad/s of a quaternion's component; Madgwick's beta.
    double zeta = 0.0;  ///< rad/s^2: speed at which the gyro's bias is learnt, with a magnetometer only.
  };
  MadgwickFilter(const WorldFrame& world, const Settings& settings) : OrientationFilter(world), settings_(settings) {}

 private:
  void correct(const Measurement& measurement) override;

  const Settings settings_;
};

}  // namespace nacelle::imu_filter
