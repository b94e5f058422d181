// SPDX-License-Identifier: Apache-2.0
#include "imu_filter/component/imu_filter_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::imu_filter::MadgwickFilterComponent>{
    .purpose =
        "Adds the orientation to the readings of an IMU, with Madgwick's filter. The parameters have the names of "
        "imu_filter_madgwick."};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::imu_filter::ComplementaryFilterComponent>{
    .purpose =
        "Adds the orientation to the readings of an IMU, with a complementary filter. The parameters have the names of "
        "imu_complementary_filter."};

NACELLE_REGISTER_COMPONENT(nacelle::imu_filter::MadgwickFilterComponent,
                           nacelle::imu_filter::ComplementaryFilterComponent)
