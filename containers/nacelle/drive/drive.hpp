// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drive/model/square_course.hpp"
#include "nacelle/base/time.hpp"
#include "process/stop_signal.hpp"

namespace nacelle::drive {

struct DriveSettings {
  std::string program;  ///< The running `nacelle`, which is started again as the container.
  std::string launch_file;
  std::vector<std::string> arguments;  ///< "name:=value", for the launch file.
  std::optional<Duration> duration;    ///< --for: run this long without driving.
  bool stay = false;                   ///< --stay: run until Ctrl-C without driving.
  std::int64_t seed = 1;
  std::string report_file, html_file;  ///< Empty: none.
  bool verbose = false;                ///< The container's own lines are shown.
  bool stamped = true;
  std::string topic = "/cmd_vel", odometry_topic = "/odom", odom_frame = "odom", base_frame = "base_footprint",
              command_frame = "base_link";
  CourseOptions course;
  std::string robot, version;                ///< For the page.
  std::map<std::string, double> nominal_hz;  ///< The rates that the launch file expects, by topic.
};

/// Starts the launch file with the simulated robot in a process of its own, drives the course (or only waits) and shows
/// the progress. Then shuts the robot down in order and prints the figures. Returns the process's exit code.
[[nodiscard]] int run_drive(const DriveSettings& settings, process::StopSignal& stop, const Clock& clock);

}  // namespace nacelle::drive
