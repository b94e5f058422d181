// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ekf/component/input.hpp"
#include "parity_streams.hpp"

namespace nacelle::ekf::parity {

/// How the filter of this tree takes a stream.
struct Switches {
  bool robot_localization_rotations = true;
};

/// Gives a stream to the inputs and the filter, as the component does: messages as they arrive, a step at each tick.
/// `after_tick(filter)` sees every step.
std::array<double, 46> run(const Stream& stream, const Switches& switches);

}  // namespace nacelle::ekf::parity
