// SPDX-License-Identifier: Apache-2.0
#include "detector/component/detector_component.hpp"
#include "nacelle/node/component.hpp"

NACELLE_REGISTER_COMPONENT(nacelle::detector::DetectorComponent)
