// SPDX-License-Identifier: Apache-2.0
#include "lidar/component/lidar_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::lidar::LidarComponent)
