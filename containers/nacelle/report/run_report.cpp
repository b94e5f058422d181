// SPDX-License-Identifier: Apache-2.0
#include "report/run_report.hpp"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace nacelle::report {
namespace {

using nlohmann::ordered_json;

// Three decimals are below every measurement here, and keep the file readable.
double rounded(double value, double per_unit = 1e3) { return std::round(value * per_unit) / per_unit; }
double microseconds(Duration duration) { return rounded(to_seconds(duration) * 1e6, 10); }

}  // namespace

Result<void, Problem> check_report_file(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const auto refused = [&](const char* what, const char* way_out) {
    return err(Problem{path, std::string{"the report cannot be written: "} + what, way_out});
  };
  if (fs::is_directory(path, unknown)) return refused("it is a folder", "name a file in it");
  if (fs::exists(path, unknown)) {
    if (::access(path.c_str(), W_OK) != 0) return refused(std::strerror(errno), "is it yours?");
    return {};
  }
  const std::string folder = fs::path{path}.has_parent_path() ? fs::path{path}.parent_path().string() : ".";
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    return refused(std::strerror(errno), "is the folder there, and yours?");
  return {};
}

std::string component_name(const std::string& node) {
  return !node.empty() && node.front() == '/' ? node.substr(1) : node;
}

ordered_json to_json(const runtime::StreamReport& stream) {
  ordered_json dropped = ordered_json::object();
  const auto count = [&](const char* cause, std::uint64_t n) {
    if (n != 0) dropped[cause] = n;
  };
  count("overwritten", stream.overwritten);
  count("full", stream.full);
  count("inactive", stream.inactive);
  count("expired", stream.expired);
  count("discarded", stream.discarded);
  count("writer_inactive", stream.inactive_unpublished);
  count("pool_dry", stream.pool_dry);
  return {{"name", stream.name},
          {"type", stream.type},
          {"hz", rounded(stream.hz())},
          {"published", stream.published},
          {"delivered", stream.delivered},
          {"readers", stream.readers},
          {"dropped", dropped},
          {"copies", stream.copies},
          {"pool_grown", stream.pool_grown},
          {"bytes_copied", stream.bytes_copied},
          {"latency_us",
           {{"p50", microseconds(stream.latency_p50)},
            {"p99", microseconds(stream.latency_p99)},
            {"max", microseconds(stream.latency_max)},
            {"handed_over", words_of(stream.handed_over)}}}};
}

ordered_json to_json(const DriveFigures& drive) {
  return {{"distance_m", rounded(drive.distance_m, 1e4)},
          {"odometry_error_m", rounded(drive.odometry_error_m, 1e5)},
          {"ekf_error_m", rounded(drive.ekf_error_m, 1e5)},
          {"odometry_error_deg", rounded(drive.odometry_error_deg)},
          {"ekf_error_deg", rounded(drive.ekf_error_deg)}};
}

ordered_json to_json(const RunReport& report) {
  ordered_json streams = ordered_json::array();
  for (const auto& stream : report.streams) streams.push_back(to_json(stream));
  ordered_json command{{"p50", nullptr}, {"p99", nullptr}};
  for (const auto& histogram : report.histograms) {
    if (histogram.name != kCommandToWheel || histogram.count == 0) continue;
    command = {{"p50", rounded(to_milliseconds(histogram.p50))}, {"p99", rounded(to_milliseconds(histogram.p99))}};
  }
  ordered_json allocations;  // null: not counted
  for (const auto& [thread, rate] : report.process.allocations_per_second) allocations[thread] = rounded(rate);
  return {{"bringup", {{"order", report.bringup_order}, {"ms", rounded(to_milliseconds(report.bringup), 10)}}},
          {"shutdown", {{"order", report.shutdown_order}}},
          {"streams", streams},
          {"drive", report.drive ? to_json(*report.drive) : ordered_json(nullptr)},
          {"command_to_wheel_ms", command},
          {"process",
           {{"cpu_percent", report.process.cpu_percent ? ordered_json(rounded(*report.process.cpu_percent, 1e2))
                                                       : ordered_json(nullptr)},
            {"rss_mb", rounded(report.process.rss_mb, 10)},
            {"threads", report.process.threads},
            {"allocations_per_second", allocations}}},
          {"seed", report.seed ? ordered_json(*report.seed) : ordered_json(nullptr)}};
}

}  // namespace nacelle::report
