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
  bool adaptive_measurement_noise = false;
  bool estimate_gyro_bias = false;
  bool zero_velocity_updates = false;
  bool detect_slip = false;
  bool teaches_gyro_bias = true;  ///< Of odomN and twistN false by default.
  Witness::Source witness = Witness::Source::None;
  double pose_gate = std::numeric_limits<double>::infinity();
  double twist_gate = std::numeric_limits<double>::infinity();
  double acceleration_gate = std::numeric_limits<double>::infinity();
};

/// robot_localization's parameters, with its defaults; but without any input configured odom0 (vx, vy of odom) and imu0 (yaw
/// rate of imu/data_raw) are the inputs.
struct EkfOptions {
  double frequency_hz = 30.0;
  FilterOptions filter;
  std::string map_frame = "map", odom_frame = "odom", base_link_frame = "base_link", world_frame = "odom";
  std::string base_link_frame_output = "base_link";  ///< What messages and the transform call the base.
  bool publish_tf = true;
  bool publish_acceleration = false;
  bool print_diagnostics = false;
  bool disabled_at_startup = false;           ///< Until the service enable is called.
  bool stamped_control = false;               ///< cmd_vel is a TwistStamped.
  bool robot_localization_rotations = false;  ///< Turns of tilted mountings as robot_localization has them.
  bool debug = false;                         ///< Write what the filter does into debug_out_file.
  std::string debug_out_file;                 ///< A path; set if debug is.
  Duration transform_time_offset{};
  double gravity_mps2 = 9.80665;
  std::vector<InputOptions> inputs;
  std::string assist_imu, assist_wheels;  ///< The inputs that the assists compare; empty without one.
  std::vector<std::string> notes;         ///< Worth a line in the log.

  /// The transform that the filter broadcasts: world -> base, or map -> odom when the world is the map.
  [[nodiscard]] const std::string& tf_parent() const { return world_frame; }
  [[nodiscard]] const std::string& tf_child() const { return corrects_odom() ? odom_frame : base_link_frame_output; }
  /// Returns true if the world is the map: the transform corrects the odometry's error.
  [[nodiscard]] bool corrects_odom() const { return world_frame == map_frame && map_frame != odom_frame; }
};

/// Declares everything, the inputs that the overrides name included.
void declare_ekf_parameters(Node& node);

/// Errors: the parameter, its value and what would be right.
[[nodiscard]] Result<EkfOptions, Problem> read_ekf_parameters(const Node& node);

}  // namespace nacelle::ekf
