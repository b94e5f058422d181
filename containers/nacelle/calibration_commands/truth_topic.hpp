// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "calibration_commands/dialogue.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::cli {

/// A pose on the floor.
struct FloorPose {
  double x_m = 0.0, y_m = 0.0, yaw_rad = 0.0;
};
/// Returns a pose as seen from another one. The yaw is in [-pi, pi].
[[nodiscard]] FloorPose seen_from(const FloorPose& here, const FloorPose& there);

/// Returns the pose in a nav_msgs/Odometry, geometry_msgs/PoseStamped or PoseWithCovarianceStamped as JSON; nothing in another type.
[[nodiscard]] std::optional<FloorPose> floor_pose_in(const nlohmann::json& message);

/// Measures where a robot stands with a topic of poses, such as another localisation: the mean of the messages that come in 0.2 s, of one
/// at least.
/// Errors: an exit code, printed: a signal, no message for `silence`, another type, a pose that moves by more than 5 cm meanwhile.
[[nodiscard]] Result<FloorPose, int> measure_pose(const Dialogue& dialogue, const std::string& container,
                                                  const std::string& topic, Duration silence);

}  // namespace nacelle::cli
