// SPDX-License-Identifier: Apache-2.0
#include "estop/component/emergency_stop_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::estop::EmergencyStopComponent>{
    .purpose =
        "Sets and releases the emergency stop: by a service, and by a button on a GPIO line. A pressed button sets it; "
        "letting go does not release it.",
    .devices = "a button or relay on a line of a GPIO chip, e.g. /dev/gpiochip0"};

NACELLE_REGISTER_COMPONENT(nacelle::estop::EmergencyStopComponent)
