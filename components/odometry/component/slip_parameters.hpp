// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nacelle/node/node.hpp"
#include "odometry/model/slip_model.hpp"

namespace nacelle::odometry {

/// Declares slip.* and the older k_left, k_right and k_turn.
void declare_slip_parameters(Node& node, const SlipModel& defaults);
[[nodiscard]] SlipModel read_slip_model(const Node& node);
/// The noise of each wheel, if one of k_left, k_right and k_turn is given; the others have their defaults.
[[nodiscard]] std::optional<StepNoise> read_step_noise(const Node& node);

}  // namespace nacelle::odometry
