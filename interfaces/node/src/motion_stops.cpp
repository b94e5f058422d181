// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/motion_stops.hpp"

namespace nacelle {

std::shared_ptr<void> make_motion_stops() { return std::make_shared<MotionStops>(); }

}  // namespace nacelle
