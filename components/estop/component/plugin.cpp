// SPDX-License-Identifier: Apache-2.0
#include "estop/component/emergency_stop_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::estop::EmergencyStopComponent)
