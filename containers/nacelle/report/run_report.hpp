// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/runtime/container.hpp"
#include "process/process_figures.hpp"

namespace nacelle::report {

/// Figures that a drive adds to a container's report.
struct DriveFigures {
  double distance_m = 0;        ///< Length of the path of the filter's poses.
  double odometry_error_m = 0;  ///< Error of the last pose of /odom against the truth, at standstill.
  double ekf_error_m = 0;       ///< The same for odom -> base_footprint.
  double odometry_error_deg =
      std::numeric_limits<double>::quiet_NaN();                     ///< Angle between yaw and true yaw; NaN: unknown.
  double ekf_error_deg = std::numeric_limits<double>::quiet_NaN();  ///< The same of the EKF.
};

/// The figures of one run of a container.
struct RunReport {
  std::vector<std::string> bringup_order;  ///< Component names as activated.
  Duration bringup{};                      ///< From exec to all active.
  std::vector<std::string> shutdown_order;
  std::vector<runtime::StreamReport> streams;  ///< Taken when no writer is active and no message in transit.
  std::optional<DriveFigures> drive;
  std::vector<runtime::HistogramReport> histograms;
  process::ProcessFigures process;
  std::optional<std::int64_t> seed;
};

/// The name of the base's histogram: from the publication of cmd_vel to the written frame.
inline constexpr const char* kCommandToWheel = "command_to_wheel";

/// Checks that a report can be written to a path, without touching the file. Errors: the reason.
[[nodiscard]] Result<void, Problem> check_report_file(const std::string& path);

/// Returns "camera" for "/camera", and "robot1/camera" for "/robot1/camera".
[[nodiscard]] std::string component_name(const std::string& node);

/// Returns the report as one JSON object. The keys' names end with the unit of a time. Absent figures are null.
[[nodiscard]] nlohmann::ordered_json to_json(const RunReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const runtime::StreamReport& stream);
[[nodiscard]] nlohmann::ordered_json to_json(const DriveFigures& drive);

/// Returns a table for users, made of the JSON object. `width`: that of the terminal.
[[nodiscard]] std::string summary_of(const nlohmann::ordered_json& report);

}  // namespace nacelle::report
