// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calibration_commands/dialogue.hpp"
#include "calibration_commands/model/yaw_integral.hpp"
#include "calibration_commands/topic_reader.hpp"

namespace nacelle::cli {

/// Measures how far a robot turns, with the z axis of a gyro that is mounted level (sensor_msgs/Imu).
///
/// Threads: one.
class GyroReference {
 public:
  /// Reads the gyro for two seconds, in which the robot must be at rest, and begins to count from there.
  /// Errors: an exit code, printed: a signal, no messages for `silence`, a robot that moves, a gyro that does not measure.
  [[nodiscard]] static Result<GyroReference, int> begin(const Dialogue& dialogue, const std::string& container,
                                                        const std::string& topic, Duration silence);

  /// Takes the readings that are here. Call it often. Errors: the container has ended, messages of another type.
  [[nodiscard]] Result<void, Problem> take();
  /// Returns the turn since the beginning, counter-clockwise positive. Errors: readings were missing.
  [[nodiscard]] Result<double, Problem> yaw_rad() const;

 private:
  GyroReference(TopicReader reader, double bias_rps) : reader_(std::move(reader)), yaw_(bias_rps) {}

  TopicReader reader_;
  calibration::YawIntegral yaw_;
};

}  // namespace nacelle::cli
