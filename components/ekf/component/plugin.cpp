// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::ekf::EkfComponent>{
    .purpose =
        "Estimates pose and velocity with an extended Kalman filter of 15 states, as robot_localization's ekf_node. "
        "Inputs are odomN, poseN, twistN and imuN, counted from 0; if none is given, odom0 and imu0 are, as below.",
    .also_with =
        "odom0:=odom\npose0:=pose\ntwist0:=twist\nimu0:=imu/data_raw\nuse_control:=true\ncontrol_config:=[true, false, "
        "false, false, false, true]\npublish_acceleration:=true"};

NACELLE_REGISTER_COMPONENT(nacelle::ekf::EkfComponent)
