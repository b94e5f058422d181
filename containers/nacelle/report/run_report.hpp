// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"
#include "nacelle/runtime/container.hpp"
#include "process/process_figures.hpp"

namespace nacelle::report {

/// What a drive adds to a container's report.
struct DriveFigures {
  double distance_m = 0;        ///< Length of the path of the filter's poses.
  double odometry_error_m = 0;  ///< Last pose of /odom against the world's truth, standing still.
  double ekf_error_m = 0;       ///< The same for odom -> base_footprint.
};

/// The figures of one run of a container.
struct RunReport {
  std::vector<std::string> bringup_order;  ///< Component names as activated.
  Duration bringup{};                      ///< From exec to all active.
  std::vector<std::string> shutdown_order;
  std::vector<runtime::StreamReport> streams;  ///< Taken when every writer was inactive, so that nothing was under way.
  std::optional<DriveFigures> drive;
  std::vector<runtime::HistogramReport> histograms;
  process::ProcessFigures process;
  std::optional<std::int64_t> seed;
};

/// The name under which the base's histogram stands: cmd_vel published to the frame written.
inline constexpr const char* kCommandToWheel = "command_to_wheel";

/// Whether a report can be written there, without touching the file. Errors: why not.
[[nodiscard]] Result<void, Problem> check_report_file(const std::string& path);

/// "/camera" is "camera", "/robot1/camera" is "robot1/camera".
[[nodiscard]] std::string component_name(const std::string& node);

/// The report as one JSON object; times in the units of the keys' names. Figures that were not taken are null.
[[nodiscard]] nlohmann::ordered_json to_json(const RunReport& report);
[[nodiscard]] nlohmann::ordered_json to_json(const runtime::StreamReport& stream);
[[nodiscard]] nlohmann::ordered_json to_json(const DriveFigures& drive);

/// A table for people, made of the JSON object. `width` is that of the terminal.
[[nodiscard]] std::string summary_of(const nlohmann::ordered_json& report);

}  // namespace nacelle::report
