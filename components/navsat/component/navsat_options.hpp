// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/node/node.hpp"
#include "navsat/model/world_alignment.hpp"

namespace nacelle::navsat {

/// A datum that the user gives: a place and the heading of the world's x axis there.
struct ManualDatum {
  GeoPoint point{};
  Eigen::Quaterniond R_EW = Eigen::Quaterniond::Identity();
};

/// The parameters of navsat_transform_node.
struct NavsatOptions {
  double frequency_hz = 10.0;
  Duration delay{};
  HeadingCorrection heading{};  ///< Its convergence is the projection's, and 0 here.
  bool zero_altitude = false;
  bool publish_filtered_gps = true;
  bool use_odometry_yaw = false;
  bool wait_for_datum = false;
  bool use_local_cartesian = false;
  bool broadcasts_cartesian = false;
  bool cartesian_is_parent = false;
  std::optional<ManualDatum> datum;
  double stddev_if_unknown_m = 4.0;
  std::string cartesian_frame;  ///< "utm" or "local_enu", with frame_prefix.

  [[nodiscard]] bool needs_imu() const { return !use_odometry_yaw && !wait_for_datum; }
};

void declare_navsat_parameters(Node& node);
/// Errors: a Problem that names the parameter.
[[nodiscard]] Result<NavsatOptions, Problem> read_navsat_parameters(const Node& node);

}  // namespace nacelle::navsat
