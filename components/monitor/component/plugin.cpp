// SPDX-License-Identifier: Apache-2.0
#include "monitor/component/monitor_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::monitor::MonitorComponent)
