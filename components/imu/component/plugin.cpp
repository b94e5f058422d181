// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::imu::ImuComponent>{
    .purpose =
        "Publishes the samples of an IMU as REP 145 says: without orientation, with it (ENU) if the device computes "
        "it, "
        "the magnetic field, and the die's temperature once a second. The messages of a sample have one stamp.",
    .devices =
        "WitMotion WT901 (serial, 9600 or 115200 baud), BNO08x in mode UART-RVC, BNO055 (serial or I2C), and on I2C "
        "MPU-6050, MPU-9250, ICM-20948, LSM6DSOX with LIS3MDL, BMI088",
    .also_with = "model:=mpu9250"};

NACELLE_REGISTER_COMPONENT(nacelle::imu::ImuComponent)
