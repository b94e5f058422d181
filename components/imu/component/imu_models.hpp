// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string_view>

namespace nacelle::imu {

/// The devices that the component speaks to.
enum class ImuModel : std::uint8_t {
  Wt901,
  Bno08xRvc,
  Bno055,
  Bno055Uart,
  Mpu6050,
  Mpu9250,
  Icm20948,
  Lsm6dsox,
  Bmi088
};

/// What a model can do, and how noisy it is by its data sheet.
struct ModelTraits {
  ImuModel model;
  std::string_view name;  ///< Of the parameter `model`.
  bool is_on_i2c;
  std::uint8_t address;  ///< On I2C, as delivered; 0 otherwise.
  bool has_angular_velocity, has_orientation, has_magnetometer, has_thermometer;
  double default_rate_hz, highest_rate_hz;
  std::span<const int> acceleration_ranges_g{};  ///< That can be set; empty: fixed.
  std::span<const int> angular_velocity_ranges_dps{};
  double angular_velocity_noise;  ///< rad/s/sqrt(Hz)
  double acceleration_noise;      ///< m/s^2/sqrt(Hz)
  double orientation_stddev;      ///< rad
  double magnetic_field_stddev;   ///< T
};

/// Every model, in the order of the enumeration.
[[nodiscard]] std::span<const ModelTraits> imu_models();
/// Null for an unknown name.
[[nodiscard]] const ModelTraits* find_imu_model(std::string_view name);

}  // namespace nacelle::imu
