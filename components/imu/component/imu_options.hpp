// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "imu/component/imu_models.hpp"
#include "imu/model/sample_correction.hpp"
#include "imu/protocol/wt901_frame.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::imu {

/// The parameters of the component.
struct ImuOptions {
  ImuModel model = ImuModel::Wt901;
  const ModelTraits* traits = &imu_models().front();
  std::string port = "/dev/ttyUSB1";  // the LiDAR's default is ttyUSB0
  unsigned baudrate = 115200;
  std::uint8_t address = 0;       ///< On I2C.
  std::uint8_t gyro_address = 0;  ///< BMI088: its second chip.
  std::uint8_t mag_address = 0;   ///< LSM6DSOX: the LIS3MDL beside it; 0: none.
  int accel_range_g = 4;
  int gyro_range_dps = 500;
  bool use_fifo = true;
  std::string frame_id = "imu_link";
  double rate_hz = 100.0;
  bool publish_orientation = true;
  double angular_velocity_stddev = 0.002;    ///< rad/s
  double linear_acceleration_stddev = 0.04;  ///< m/s^2
  double orientation_stddev = 0.05;          ///< rad
  double magnetic_field_stddev = 5e-7;       ///< T
  double magnetic_field_scale = 1.5e-7;  ///< T per count: the unit of the AK8963 in most WT901s (not verified for all)
  SampleCorrection correction{};
  bool configure_device = true;   ///< Set rate and output at start; false takes the device as it is.
  Duration command_pause = 20ms;  ///< After each command; the device is slow in taking them.
  bool calibrate_gyro = true;
  std::size_t calibration_samples = 100;
  double calibration_max_stddev = 0.01;  ///< rad/s; more scatter means that the robot moves.
  double calibration_max_bias = 0.1;     ///< rad/s; more means that it turns evenly.
  DeviceOptions device{};
  Duration port_timeout = 2s;   ///< With required_device: how long configure waits for the port to appear.
  Duration silence_limit = 1s;  ///< With device_lost: fault, no sample for this long is one. Must be positive.
};

/// The frames that this component asks a WT901 for and waits for: acceleration, angular velocity, angles, field, quaternion.
inline constexpr Wt901Mask kOutputMask = mask_bit(Wt901Type::Acceleration) | mask_bit(Wt901Type::AngularVelocity) |
                                         mask_bit(Wt901Type::Angles) | mask_bit(Wt901Type::MagneticField) |
                                         mask_bit(Wt901Type::Quaternion);

/// Declares the parameters with their ranges; defaults are those of the chosen model. Touches no hardware.
void declare_imu_parameters(Node& node);

/// Reads the declared parameters and checks them together.
/// Errors: a Problem that names the parameter, its value and the way out.
[[nodiscard]] Result<ImuOptions, Problem> read_imu_parameters(const Node& node);

}  // namespace nacelle::imu
