// SPDX-License-Identifier: Apache-2.0
#include "battery/component/ina219_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::battery::Ina219Component>{
    .purpose =
        "Publishes the voltage and the current of a battery, which a monitor between it and its load measures. What is "
        "not known is NaN.",
    .devices = "INA219 current and power monitors on an I2C bus, e.g. /dev/i2c-1"};

NACELLE_REGISTER_COMPONENT(nacelle::battery::Ina219Component)
