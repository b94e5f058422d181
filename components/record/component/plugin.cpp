// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/component.hpp"
#include "record/component/play_component.hpp"
#include "record/component/record_component.hpp"

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::record::RecordComponent>{
    .purpose = "Records topics into MCAP files, as `ros2 bag record` does."};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::record::PlayComponent>{
    .purpose = "Publishes a recording into its container, as `ros2 bag play` does."};

NACELLE_REGISTER_COMPONENT(nacelle::record::RecordComponent, nacelle::record::PlayComponent)
