// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "range/component/hc_sr04_component.hpp"
#include "range/component/vl53l0x_component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::range::HcSr04Component>{
    .purpose =
        "Publishes the distance that an ultrasonic sensor measures: +Inf if nothing is in range, -Inf if it is too "
        "near.",
    .devices =
        "HC-SR04 ultrasonic sensors, and others with a trigger and an echo line, on a GPIO chip, e.g. /dev/gpiochip0"};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::range::Vl53l0xComponent>{
    .purpose =
        "Publishes the distance that a time-of-flight sensor measures: +Inf if nothing is in range, -Inf if it is too "
        "near, NaN if the measurement means nothing.",
    .devices = "VL53L0X time-of-flight sensors on an I2C bus, e.g. /dev/i2c-1"};

NACELLE_REGISTER_COMPONENT(nacelle::range::HcSr04Component, nacelle::range::Vl53l0xComponent)
