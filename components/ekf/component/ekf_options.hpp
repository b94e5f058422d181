// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "ekf/model/filter.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::ekf {

enum class InputKind : std::uint8_t { Odometry, Pose, Twist, Imu };

/// One odomN, poseN, twistN or imuN.
struct InputOptions {
  InputKind kind{};
  std::string name;   ///< "odom0"
  std::string topic;  ///< As given; relative to the node's namespace.
  StateMask config{};
  int queue_size = 10;
  bool differential = false;
  bool relative = false;
  bool pose_use_child_frame = false;
  bool remove_gravitational_acceleration = false;
  double pose_gate = std::numeric_limits<double>::infinity();
  double twist_gate = std::numeric_limits<double>::infinity();
  double acceleration_gate = std::numeric_limits<double>::infinity();
};

/// robot_localization's parameters. The defaults differ where a wheeled robot with an IMU needs it: two_d_mode is true, and
/// without any input configured odom0 (vx, vy of odom) and imu0 (yaw rate of imu/data_raw) are the inputs.
struct EkfOptions {
  double frequency_hz = 30.0;
  FilterOptions filter;
  std::string map_frame = "map", odom_frame = "odom", base_link_frame = "base_link", world_frame = "odom";
  bool publish_tf = true;
  bool publish_acceleration = false;
  bool print_diagnostics = false;
  Duration transform_time_offset{};
  double gravity_mps2 = 9.80665;
  std::vector<InputOptions> inputs;
  std::vector<std::string> notes;  ///< Worth a line in the log.

  /// The transform that the filter broadcasts: world -> base, or map -> odom when the world is the map.
  [[nodiscard]] const std::string& tf_parent() const { return world_frame; }
  [[nodiscard]] const std::string& tf_child() const {
    return world_frame == map_frame && map_frame != odom_frame ? odom_frame : base_link_frame;
  }
};

/// Declares everything, the inputs that the overrides name included.
void declare_ekf_parameters(Node& node);

/// Errors: the parameter, its value and what would be right.
[[nodiscard]] Result<EkfOptions, Problem> read_ekf_parameters(const Node& node);

}  // namespace nacelle::ekf
