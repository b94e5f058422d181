// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "odometry/component/odometry_component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::odometry::OdometryComponent)
