// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::imu::ImuComponent>{
    .purpose =
        "Publishes the samples of an IMU as REP 145 says: without orientation, with it (ENU), and the magnetic field. "
        "The three messages of a sample have one stamp.",
    .devices = "WitMotion WT901 IMUs, on a serial line at 9600 baud, as delivered, or 115200"};

NACELLE_REGISTER_COMPONENT(nacelle::imu::ImuComponent)
