// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/diff_drive_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::diff_drive::DiffDriveComponent>{
    .purpose =
        "Drives a base on two driven wheels: turns velocity commands into wheel speeds within limits, and publishes "
        "joint states and the battery. Without topics.NAME.topic its one input is cmd_vel; with it, the inputs are "
        "those topics only.",
    .devices =
        "motor boards on a CAN bus (can_interface): ODrive, VESC; on a serial line: Waveshare UGV boards (General "
        "Driver for "
        "Robots), RoboClaw (packet serial), VESC (UART), ODrive (ASCII), Hiwonder RRC, home-made boards",
    .also_with = "topics.NAME.topic:=cmd_vel_joy\nlocks.NAME.topic:=pause_navigation\npublish_limited_velocity:=true"};

NACELLE_REGISTER_COMPONENT(nacelle::diff_drive::DiffDriveComponent)
