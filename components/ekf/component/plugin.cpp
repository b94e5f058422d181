// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::ekf::EkfComponent)
