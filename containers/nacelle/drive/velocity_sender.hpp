// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "control/client.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"

namespace nacelle::drive {

/// Sends velocity commands through a container's control socket. Threads: one, the client's.
class VelocitySender {
 public:
  /// Opens a writer of `topic`. `stamped`: geometry_msgs/msg/TwistStamped with `frame`; otherwise
  /// geometry_msgs/msg/Twist.
  [[nodiscard]] static Result<VelocitySender, Problem> open(control::Client& client, const std::string& topic,
                                                            bool stamped, std::string frame);

  /// Sends a forward speed and a yaw rate for the base.
  [[nodiscard]] Result<void, Problem> send(double speed_mps, double yaw_rate_rps, WallTime stamp);

 private:
  VelocitySender(control::Client& client, std::uint16_t handle, bool stamped, std::string frame)
      : client_(&client), handle_(handle), stamped_(stamped), frame_(std::move(frame)) {}

  control::Client* client_;
  std::uint16_t handle_;
  bool stamped_;
  std::string frame_;
};

}  // namespace nacelle::drive
