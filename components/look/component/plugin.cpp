// SPDX-License-Identifier: Apache-2.0
#include "look/component/look_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::look::LookComponent>{
    .purpose = "Shows the robot in a browser, and speaks Foxglove's WebSocket protocol."};

NACELLE_REGISTER_COMPONENT(nacelle::look::LookComponent)
