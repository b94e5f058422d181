// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

namespace nacelle::cli {

/// What `nacelle imu calibrate --drive` drives, and with which base.
struct DriveCourse {
  std::string base = "diff_drive", command = "cmd_vel", joints = "joint_states";
  double radius_m = 0.4, yaw_rate_rps = 1.0;
  std::size_t eights = 2;
  bool twist = false, yes = false;
};

/// What `nacelle imu calibrate` was asked for.
struct ImuWish {
  std::string container, node = "imu", output = "imu_calibration.yaml";
  std::string data = "imu/data_raw", field = "imu/mag";
  double rest_s = 2.0, turn_s = 30.0, wait_s = 5.0;
  bool gyro = false, accel = false, mag = false, drive = false;  ///< None: all that the IMU has, without a drive.
  DriveCourse course;
};

/// Measures the errors of the IMU of a running robot with the user's hands or by driving, and writes its corrections. Returns the exit
/// code.
int calibrate_imu(const ImuWish& wish);

}  // namespace nacelle::cli
