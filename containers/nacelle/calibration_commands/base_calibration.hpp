// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace nacelle::cli {

/// What `nacelle base calibrate` was asked for.
struct BaseWish {
  std::string container, node = "diff_drive", output = "base_calibration.yaml";
  std::string command = "cmd_vel", joints = "joint_states";
  std::string gyro;                                        ///< Measures the turns; empty: the user does.
  double distance_m = 2.0, turns = 2.0;                    ///< 0: that part is left out.
  double measured_distance_m = 0.0, measured_turns = 0.0;  ///< 0: asked for.
  double speed_mps = 0.2, yaw_rate_rps = 0.6, wait_s = 5.0;
  bool twist = false, yes = false;
  bool umbmark = false;  ///< Squares both ways, instead of the turns.
  double side_m = 1.0;
  std::size_t squares = 5;                 ///< Each way.
  std::vector<std::string> measured_ends;  ///< "X,Y" of each square, clockwise ones first; else asked for.
  std::string truth;                       ///< A topic that measures instead.
  std::string odometry = "odometry";       ///< The node that has the noise.
};

/// Drives a straight line and turns on the spot, or squares, asks what was measured, and writes the multipliers of the wheels. Whatever
/// ends it, the base has been commanded to stand still. Returns the exit code.
int calibrate_base(const BaseWish& wish);

}  // namespace nacelle::cli
