// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace nacelle::cli {

/// What `nacelle sim truth --publish` was asked for.
struct TruthTopic {
  std::string container;
  std::string topic;  ///< nav_msgs/msg/Odometry; a relative name is below /.
  double rate_hz = 50.0;
};

/// Publishes the true pose and velocity of the robot of a simulated world until Ctrl-C, or until the world or the container ends.
/// For tests and measurements; no component of a robot reads it. `directory`: the world's. Returns the exit code.
int publish_truth(const std::string& directory, const TruthTopic& wish);

}  // namespace nacelle::cli
