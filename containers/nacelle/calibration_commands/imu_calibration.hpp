// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

/// What `nacelle imu calibrate` was asked for.
struct ImuWish {
  std::string container, node = "imu", output = "imu_calibration.yaml";
  std::string data = "imu/data_raw", field = "imu/mag";
  double rest_s = 2.0, turn_s = 30.0, wait_s = 5.0;
  bool gyro = false, accel = false, mag = false;  ///< None: all that the IMU has.
};

/// Measures the errors of the IMU of a running robot with the user's hands, and writes its corrections. Returns the exit code.
int calibrate_imu(const ImuWish& wish);

}  // namespace nacelle::cli
