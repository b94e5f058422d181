// SPDX-License-Identifier: Apache-2.0
#include "joy/component/joy_component.hpp"
#include "joy/component/teleop_twist_joy_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::joy::JoyComponent>{
    .purpose =
        "Publishes the buttons and axes of a gamepad or joystick, in the order and with the signs and parameters of "
        "ROS 2's joy. If the gamepad "
        "disappears, one message with everything at rest is published, and nothing until it is back.",
    .devices = "gamepads and joysticks that the kernel knows (evdev), by USB or Bluetooth"};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::joy::TeleopTwistJoyComponent>{
    .purpose =
        "Turns the axes of a gamepad into velocity commands while its enable or turbo button is held, with the rules "
        "and parameters of "
        "ROS 2's teleop_twist_joy.",
    .also_with = "publish_stamped_twist:=true"};

NACELLE_REGISTER_COMPONENT(nacelle::joy::JoyComponent, nacelle::joy::TeleopTwistJoyComponent)
