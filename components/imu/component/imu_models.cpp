// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_models.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace nacelle::imu {
namespace {

constexpr double kDps = std::numbers::pi / 180.0;
constexpr double kMicroG = 9.80665e-6;

constexpr std::array kAcceleration2To16{2, 4, 8, 16};
constexpr std::array kAcceleration3To24{3, 6, 12, 24};
constexpr std::array kRate250To2000{250, 500, 1000, 2000};
constexpr std::array kRate125To2000{125, 250, 500, 1000, 2000};

// Noise densities: data sheets of WT901 (none given: that of the MPU-9250 in it), BNO080 (section 6.7), BNO055 (tables 0-2, 0-3),
// MPU-6050 (6.1, 6.2), MPU-9250 (3.1, 3.2), ICM-20948 (3.1, 3.2), LSM6DSOX (4.1), BMI088 (1.2, 1.3); magnetometers AK8963, AK09916 and
// LIS3MDL. Not read anew for this table: see docs/hardware.md.
constexpr std::array kModels{
    ModelTraits{ImuModel::Wt901,
                "wt901",
                false,
                0,
                true,
                true,
                true,
                true,
                100,
                200,
                {},
                {},
                0.01 * kDps,
                300 * kMicroG,
                0.05,
                5e-7},
    ModelTraits{ImuModel::Bno08xRvc,
                "bno08x_rvc",
                false,
                0,
                false,
                true,
                false,
                false,
                100,
                100,
                {},
                {},
                0.014 * kDps,
                230 * kMicroG,
                0.06,
                5e-7},
    ModelTraits{ImuModel::Bno055,
                "bno055",
                true,
                0x28,
                true,
                true,
                true,
                true,
                100,
                100,
                {},
                {},
                0.014 * kDps,
                190 * kMicroG,
                0.05,
                1e-6},
    ModelTraits{ImuModel::Bno055Uart,
                "bno055_uart",
                false,
                0,
                true,
                true,
                true,
                true,
                50,
                100,
                {},
                {},
                0.014 * kDps,
                190 * kMicroG,
                0.05,
                1e-6},
    ModelTraits{ImuModel::Mpu6050, "mpu6050", true, 0x68, true, false, false, true, 100, 1000, kAcceleration2To16,
                kRate250To2000, 0.005 * kDps, 400 * kMicroG, 0.05, 5e-7},
    ModelTraits{ImuModel::Mpu9250, "mpu9250", true, 0x68, true, false, true, true, 100, 1000, kAcceleration2To16,
                kRate250To2000, 0.01 * kDps, 300 * kMicroG, 0.05, 5e-7},
    ModelTraits{ImuModel::Icm20948, "icm20948", true, 0x68, true, false, true, true, 100, 1100, kAcceleration2To16,
                kRate250To2000, 0.015 * kDps, 230 * kMicroG, 0.05, 5e-7},
    ModelTraits{ImuModel::Lsm6dsox, "lsm6dsox", true, 0x6A, true, false, true, true, 104, 833, kAcceleration2To16,
                kRate125To2000, 0.0038 * kDps, 110 * kMicroG, 0.05, 4.1e-7},
    ModelTraits{ImuModel::Bmi088, "bmi088", true, 0x18, true, false, false, true, 100, 400, kAcceleration3To24,
                kRate125To2000, 0.014 * kDps, 190 * kMicroG, 0.05, 5e-7}};

}  // namespace

std::span<const ModelTraits> imu_models() { return kModels; }

const ModelTraits* find_imu_model(std::string_view name) {
  const auto* const found = std::ranges::find(kModels, name, &ModelTraits::name);
  return found == kModels.end() ? nullptr : found;
}

}  // namespace nacelle::imu
