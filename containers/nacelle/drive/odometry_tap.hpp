// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "control/client.hpp"
#include "drive/model/path_track.hpp"
#include "nacelle/base/bytes.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::drive {

/// Reads poses of an odometry topic of a running container, as a tool: it does not count as a reader of the stream.
/// Threads: one.
class OdometryTap {
 public:
  /// Takes over a connection. Errors: no such topic; its type is not nav_msgs/msg/Odometry.
  [[nodiscard]] static Result<OdometryTap, Problem> open(control::Client client, const std::string& topic);

  /// Reads what has come and returns the newest pose so far, or nothing. After the container has ended, the last one stays.
  [[nodiscard]] const std::optional<StampedPose>& newest();

 private:
  explicit OdometryTap(control::Client client) : client_(std::move(client)) {}

  control::Client client_;
  Bytes bytes_;
  std::optional<StampedPose> newest_;
  bool ended_ = false;
};

}  // namespace nacelle::drive
