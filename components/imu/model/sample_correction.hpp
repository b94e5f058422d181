// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "imu/model/sample_assembler.hpp"

namespace nacelle::imu {

/// A 3x3 matrix, row by row.
using Matrix3 = std::array<double, 9>;
inline constexpr Matrix3 kIdentity3{1, 0, 0, 0, 1, 0, 0, 0, 1};

/// What is known of a sensor's errors, and how it is mounted.
struct SampleCorrection {
  Vector3 gyro_bias_rps{};                   ///< Read at rest; taken off.
  Vector3 acceleration_bias_mps2{};          ///< Taken off first ...
  Matrix3 acceleration_matrix = kIdentity3;  ///< ... then this scales and turns.
  Vector3 field_bias_t{};                    ///< Hard iron; taken off first ...
  Matrix3 field_matrix = kIdentity3;         ///< ... then this undoes the soft iron.
  Vector3 mounting_rpy_rad{};  ///< Fixed-axis roll, pitch, yaw of the sensor's axes in the published frame (REP 103).
};

/// Applies a correction to samples: errors off in the sensor's axes, then turned into the published frame.
///
/// Threads: const, any. Allocates: nothing.
class SampleCorrector {
 public:
  explicit SampleCorrector(const SampleCorrection& correction);
  void apply(Sample& sample) const;

 private:
  const SampleCorrection correction_;
  Orientation mounting_;  ///< R_FS: sensor to published frame.
  Matrix3 R_FS_;
};

}  // namespace nacelle::imu
