// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "range/component/hc_sr04_component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::range::HcSr04Component>{
    .purpose =
        "Publishes the distance that an ultrasonic sensor measures: +Inf if nothing is in range, -Inf if it is too "
        "near.",
    .devices =
        "HC-SR04 ultrasonic sensors, and others with a trigger and an echo line, on a GPIO chip, e.g. /dev/gpiochip0"};

NACELLE_REGISTER_COMPONENT(nacelle::range::HcSr04Component)
