// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "report/run_report.hpp"
#include "report/stream_rows.hpp"

namespace nacelle::report {
namespace {

using nlohmann::ordered_json;

std::string joined(const ordered_json& names, const char* separator) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : separator) + name.get<std::string>();
  return text;
}

std::string drops_of(const ordered_json& dropped) {
  std::string text;
  for (const auto& [cause, n] : dropped.items())
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n.get<std::uint64_t>(), cause);
  return text.empty() ? "0" : text;
}

std::string number_or_dash(const ordered_json& value, const char* format) {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : "-";
}

}  // namespace

std::string summary_of(const ordered_json& report) {
  std::string text;
  const auto line = [&](const std::string& content) { text.append(content).push_back('\n'); };

  std::size_t name_width = 6;
  const auto rows = rows_of(report["streams"]);
  for (const auto& row : rows) name_width = std::max(name_width, row.label.size());
  line(fmt::format("{:<{}}  {:>7} {:>9} {:>9} {:>7} {:>6}  {:>19} {:<14}  {}", "stream", name_width, "Hz", "published",
                   "delivered", "readers", "copies", "p50/p99/max us", "", "dropped"));
  for (const auto& row : rows) {
    const auto& stream = *row.stream;
    const auto& latency = stream["latency_us"];
    line(fmt::format("{:<{}}  {:>7.2f} {:>9} {:>9} {:>7} {:>6}  {:>19} {:<14}  {}", row.label, name_width,
                     stream["hz"].get<double>(), stream["published"].get<std::uint64_t>(),
                     stream["delivered"].get<std::uint64_t>(), stream["readers"].get<std::uint64_t>(),
                     stream["copies"].get<std::uint64_t>(),
                     fmt::format("{:.0f}/{:.0f}/{:.0f}", latency["p50"].get<double>(), latency["p99"].get<double>(),
                                 latency["max"].get<double>()),
                     latency["handed_over"].get<std::string>(), drops_of(stream["dropped"])));
  }
  line("");
  if (const auto& drive = report["drive"]; drive.is_object()) {
    const auto error = [&](const char* metres, const char* degrees) {
      if (!drive[metres].is_number()) return std::string{"unknown"};
      return fmt::format("{:.1f} mm", drive[metres].get<double>() * 1e3) +
             (drive[degrees].is_number() ? fmt::format(" and {:.2f} deg", drive[degrees].get<double>()) : "");
    };
    line(fmt::format("drive      {:.2f} m; error at the end: odometry {}, EKF {}", drive["distance_m"].get<double>(),
                     error("odometry_error_m", "odometry_error_deg"), error("ekf_error_m", "ekf_error_deg")));
  }
  if (const auto& command = report["command_to_wheel_ms"]; command["p99"].is_number()) {
    line(fmt::format("cmd_vel    to the wheels: p50 {} ms, p99 {} ms", number_or_dash(command["p50"], "{:.2f}"),
                     number_or_dash(command["p99"], "{:.2f}")));
  }
  const auto& process = report["process"];
  const auto& cpu = process["cpu_percent"];
  line(fmt::format("process    {}, {:.1f} MB, {} threads",
                   cpu.is_number() ? fmt::format("{:.1f} % of one core", cpu.get<double>())
                                   : std::string{"CPU not measured: the run was too short"},
                   process["rss_mb"].get<double>(), process["threads"].get<std::uint64_t>()));
  std::string allocations;
  for (const auto& [thread, rate] : process["allocations_per_second"].items()) {
    if (rate.get<double>() != 0)
      allocations += fmt::format("{}{} {:.1f}/s", allocations.empty() ? "" : ", ", thread, rate.get<double>());
  }
  if (!process["allocations_per_second"].empty()) {
    line("heap       " +
         (allocations.empty() ? "no allocation on any thread" : allocations + "; 0 on every other thread"));
  }
  line(fmt::format("bring-up   {:.0f} ms: {}", report["bringup"]["ms"].get<double>(),
                   joined(report["bringup"]["order"], " ")));
  line("shutdown   " + joined(report["shutdown"]["order"], " "));
  return text;
}

}  // namespace nacelle::report
