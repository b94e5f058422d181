// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "transforms/component/transforms_component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::transforms::TransformsComponent>{
    .purpose =
        "Publishes the robot description and the transforms of its joints, as robot_state_publisher, and fills the "
        "transform buffer that all components share."};

NACELLE_REGISTER_COMPONENT(nacelle::transforms::TransformsComponent)
