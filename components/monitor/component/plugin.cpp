// SPDX-License-Identifier: Apache-2.0
#include "monitor/component/monitor_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::monitor::MonitorComponent>{
    .purpose = "Reads any topics and publishes the rate, age and gaps of each as diagnostics.",
    .also_with = "streams:=[/scan, /front/range sensor_msgs/msg/Range]"};

NACELLE_REGISTER_COMPONENT(nacelle::monitor::MonitorComponent)
