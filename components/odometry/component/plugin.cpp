// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "odometry/component/odometry_component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::odometry::OdometryComponent>{
    .purpose = "Turns the joint states of two driven wheels into odometry."};

NACELLE_REGISTER_COMPONENT(nacelle::odometry::OdometryComponent)
