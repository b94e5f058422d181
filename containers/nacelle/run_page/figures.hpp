// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace nacelle::run_page {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A value at a time of the run.
struct Sample {
  double time_s = 0.0, value = 0.0;
};

/// A pose against the truth, both at the pose's own stamp. Not finite: unknown.
struct PoseError {
  double distance_m = kUnknown, yaw_deg = kUnknown;  ///< Never negative.
};

struct Position {
  double x_m = kUnknown, y_m = kUnknown;
};

/// Where the robot is at one time, and where odometry and EKF say that it is. Frame: odom, which begins where the world does.
struct PathSample {
  double time_s = 0.0;
  Position truth, odometry, ekf;
  PoseError odometry_error, ekf_error;
};

struct StreamFigures {
  std::string name;
  double nominal_hz = kUnknown;  ///< What the launch file expects. Not finite: nothing.
  double hz = 0.0, lowest_hz = kUnknown;
  std::vector<Sample> rates_hz;  ///< Over the run.
  std::uint64_t published = 0, dropped = 0, copies = 0;
  double p50_us = 0.0, p99_us = 0.0, max_us = 0.0;  ///< From publish() to the callback. 0: no message was read.
};

/// The figures of one run, as the page shows them.
struct Figures {
  std::string robot, launch_file, version, date;
  std::vector<std::string> arguments;  ///< "name:=value"
  std::int64_t seed = 0;
  std::string failure;  ///< Why the run ended early; empty: it did not.

  double time_s = 0.0;
  double distance_m = kUnknown;         ///< Not finite: not driven.
  PoseError odometry_error, ekf_error;  ///< At the end, at standstill.
  double cpu_percent = kUnknown;        ///< Of one core, in the steady state. Not finite: the run was too short.
  double rss_mb = kUnknown;
  std::vector<std::string> faults;

  bool has_truth = false;
  std::vector<PathSample> path;
  std::vector<StreamFigures> streams;
  double command_p50_us = kUnknown,
         command_p99_us = kUnknown;           ///< From the publication of cmd_vel to the written frame.
  std::vector<Sample> cpu_percents, rss_mbs;  ///< Over the run.
};

}  // namespace nacelle::run_page
