// SPDX-License-Identifier: Apache-2.0
#include "detector/component/detector_component.hpp"
#include "nacelle/node/component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::detector::DetectorComponent>{
    .purpose =
        "Finds discs of a known colour and size in images, and publishes their positions: one message for each image, "
        "empty without a disc."};

NACELLE_REGISTER_COMPONENT(nacelle::detector::DetectorComponent)
