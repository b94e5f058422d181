// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/node/node.hpp"
#include "odometry/model/slip_model.hpp"

namespace nacelle::odometry {

/// diff_drive_controller's parameters, as far as odometry has a part in them, and the noise of a step.
struct OdometryOptions {
  std::vector<std::string> left_wheel_names{"left_wheel_joint"};
  std::vector<std::string> right_wheel_names{"right_wheel_joint"};
  double wheel_separation_m = 0.30;
  double wheel_radius_m = 0.033;
  double wheel_separation_multiplier = 1.0;
  double left_wheel_radius_multiplier = 1.0;
  double right_wheel_radius_multiplier = 1.0;
  std::string odom_frame_id = "odom";
  std::string base_frame_id = "base_link";
  std::array<double, 6> pose_covariance_diagonal{1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6};  ///< Where the covariance starts.
  std::array<double, 6> twist_covariance_diagonal{1e-5, 1e-5, 1e-6, 1e-6, 1e-6, 1e-4};  ///< The least it is.
  bool enable_odom_tf = true;
  int velocity_rolling_window_size = 1;
  SlipModel slip;
  std::optional<StepNoise> noise;  ///< k_left, k_right, k_turn, if one of them is given: in place of `slip`.
  double max_wheel_speed_rps = 40.0;
  double position_range_rad = 0.0;  ///< Wheel positions count in a circle of so much; 0: found out.

  [[nodiscard]] double separation_m() const { return wheel_separation_m * wheel_separation_multiplier; }
  [[nodiscard]] double left_radius_m() const { return wheel_radius_m * left_wheel_radius_multiplier; }
  [[nodiscard]] double right_radius_m() const { return wheel_radius_m * right_wheel_radius_multiplier; }
  [[nodiscard]] StepVariance variance_of(const WheelStep& step) const {
    return noise ? odometry::variance_of(step, separation_m(), *noise)
                 : odometry::variance_of(step, separation_m(), slip);
  }
};

/// Errors: one sentence about the first parameter that is wrong.
[[nodiscard]] Result<OdometryOptions, Problem> validated(OdometryOptions options);

void declare_odometry_parameters(Node& node, const OdometryOptions& defaults = {});
/// Errors: as validated().
[[nodiscard]] Result<OdometryOptions, Problem> read_odometry_parameters(const Node& node);

}  // namespace nacelle::odometry
