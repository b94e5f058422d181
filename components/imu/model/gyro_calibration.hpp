// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "imu/model/wt901_units.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::imu {

/// Why the readings are no calibration.
enum class CalibrationFault : std::uint8_t {
  TooFewSamples,  ///< Not all readings have come yet.
  Moving,         ///< The readings scatter more than a gyro at rest does. The robot must stand still.
  Turning         ///< The readings are steady but too large for a bias: the robot turns evenly.
};

/// The mean angular velocity that the gyro reports at rest.
struct GyroBias {
  Vector3 mean_rps{};
  double stddev_rps{};  ///< Largest of the three axes' standard deviations.
};

/// Estimates the bias of a gyro from readings at rest (mean and variance by Welford's method).
///
/// Threads: one. Allocates: nothing.
class GyroCalibration {
 public:
  GyroCalibration(std::size_t samples_needed, double max_stddev_rps, double max_bias_rps)
      : needed_(samples_needed), max_stddev_rps_(max_stddev_rps), max_bias_rps_(max_bias_rps) {}

  /// Takes a reading; those after the last needed one are ignored.
  void add(const Vector3& angular_velocity_rps);
  [[nodiscard]] bool is_full() const { return count_ >= needed_; }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// The mean so far.
  [[nodiscard]] const Vector3& mean_rps() const { return mean_; }
  /// The scatter so far, of the worst axis.
  [[nodiscard]] double stddev_rps() const;
  /// The mean so far, of the worst axis, without its sign.
  [[nodiscard]] double largest_mean_rps() const;
  [[nodiscard]] Result<GyroBias, CalibrationFault> result() const;
  void restart();

 private:
  std::size_t needed_;
  double max_stddev_rps_;
  double max_bias_rps_;
  std::size_t count_ = 0;
  Vector3 mean_{};
  Vector3 squares_{};
};

}  // namespace nacelle::imu
