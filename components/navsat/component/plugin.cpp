// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "navsat/component/navsat_transform_component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::navsat::NavsatTransformComponent>{
    .purpose =
        "Turns GPS fixes into positions in the frame of a filter, and the filter's estimate into fixes. Topics, "
        "services "
        "and parameters have the names of robot_localization's navsat_transform_node."};

NACELLE_REGISTER_COMPONENT(nacelle::navsat::NavsatTransformComponent)
