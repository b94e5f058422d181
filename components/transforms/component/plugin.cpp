// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "transforms/component/transforms_component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::transforms::TransformsComponent)
