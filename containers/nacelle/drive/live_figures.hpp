// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "control/wire.hpp"
#include "drive/model/square_course.hpp"
#include "nacelle/base/problem.hpp"

namespace nacelle::drive {

// What the answers of a container's control socket say about a drive. Pure.

/// Returns the pose of a transform on the floor.
[[nodiscard]] PlanarPose planar(const control::TransformAnswer& X);
[[nodiscard]] double yaw_of(const std::array<double, 4>& rotation_xyzw);

/// Returns one problem for each component that is faulted or has an open fault. `stats`: the container's live figures.
[[nodiscard]] std::vector<Problem> faults_of(const nlohmann::json& stats);

}  // namespace nacelle::drive
