// SPDX-License-Identifier: Apache-2.0
#include "imu/component/imu_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::imu::ImuComponent)
