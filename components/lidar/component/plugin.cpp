// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::lidar::LidarComponent>{
    .purpose = "Publishes one scan for each turn of a LiDAR, counter-clockwise from its front mark.",
    .devices =
        "LDROBOT LD06, LD19, STL-19P and STL-27L; SLAMTEC RPLIDAR A1, A2, A3, C1 and S series; YDLIDAR X2, X4, G2, G4 "
        "and G6; on a serial line"};

NACELLE_REGISTER_COMPONENT(nacelle::lidar::LidarComponent)
