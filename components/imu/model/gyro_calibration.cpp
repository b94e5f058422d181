// SPDX-License-Identifier: Apache-2.0
#include "imu/model/gyro_calibration.hpp"

#include <algorithm>
#include <cmath>

namespace nacelle::imu {

void GyroCalibration::add(const Vector3& angular_velocity_rps) {
  if (is_full()) return;
  ++count_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double before = angular_velocity_rps[axis] - mean_[axis];
    mean_[axis] += before / static_cast<double>(count_);
    squares_[axis] += before * (angular_velocity_rps[axis] - mean_[axis]);
  }
}

double GyroCalibration::stddev_rps() const {
  if (count_ < 2) return 0.0;
  return std::sqrt(*std::max_element(squares_.begin(), squares_.end()) / static_cast<double>(count_ - 1));
}

double GyroCalibration::largest_mean_rps() const {
  return std::max({std::abs(mean_[0]), std::abs(mean_[1]), std::abs(mean_[2])});
}

Result<GyroBias, CalibrationFault> GyroCalibration::result() const {
  if (!is_full()) return err(CalibrationFault::TooFewSamples);
  if (stddev_rps() > max_stddev_rps_) return err(CalibrationFault::Moving);
  if (largest_mean_rps() > max_bias_rps_) return err(CalibrationFault::Turning);
  return GyroBias{mean_, stddev_rps()};
}

void GyroCalibration::restart() {
  count_ = 0;
  mean_ = {};
  squares_ = {};
}

}  // namespace nacelle::imu
