// SPDX-License-Identifier: Apache-2.0
#include "drive/run_recorder.hpp"

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <ctime>

#include "drive/live_figures.hpp"
#include "report/stream_rows.hpp"
#include "simulation/port/truth_file.hpp"

namespace nacelle::drive {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostFaults = 100;

double number_or_unknown(const ordered_json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : run_page::kUnknown;
}

/// Returns "2026-11-28 15:04:05 +0100".
std::string local_date(WallTime at) {
  const auto seconds = static_cast<std::time_t>(std::chrono::floor<std::chrono::seconds>(at.since_origin).count());
  std::tm local{};
  ::localtime_r(&seconds, &local);
  std::array<char, 64> text{};
  return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S %z", &local)};
}

run_page::StreamFigures stream_figures(const report::StreamRow<ordered_json>& row) {
  const ordered_json& stream = *row.stream;
  const auto& latency = stream["latency_us"];
  run_page::StreamFigures figures;
  figures.name = row.label;
  figures.hz = stream["hz"];
  figures.published = stream["published"];
  for (const auto& count : stream["dropped"]) figures.dropped += count.get<std::uint64_t>();
  figures.copies = stream["copies"];
  figures.p50_us = latency["p50"];
  figures.p99_us = latency["p99"];
  figures.max_us = latency["max"];
  return figures;
}

}  // namespace

void RunRecorder::note_pose(const control::TransformAnswer& X_OB, MonotonicTime now, WallTime wall_now) {
  if (const auto truth = simulation::read_truth(truth_file_))
    path_.note_truth({wall_now, {truth.value().x_m, truth.value().y_m, truth.value().yaw_rad}});
  if (now < next_pose_) return;
  next_pose_ = now + kPosePeriod;
  time_s_ = to_seconds(now - begin_);
  std::optional<StampedPose> ekf;
  if (X_OB.known) ekf = StampedPose{X_OB.stamp, planar(X_OB)};
  path_.add(time_s_, odometry_ ? odometry_->newest() : std::nullopt, ekf);
}

void RunRecorder::note_stats(const nlohmann::json& stats, MonotonicTime now) {
  time_s_ = to_seconds(now - begin_);
  LoadTrack::Counts published;
  for (const auto& stream : stats["streams"]) published.emplace_back(report::stream_key(stream), stream["published"]);
  load_.add(time_s_, stats.value("cpu_s", 0.0), stats.value("rss_mb", 0.0), published);
  for (const Problem& fault : faults_of(stats)) {
    const std::string text = fault.text();
    if (faults_.size() < kMostFaults && seen_faults_.insert(text).second) faults_.push_back(text);
  }
}

run_page::Figures RunRecorder::figures(const ordered_json& report, const DriveSettings& settings) const {
  run_page::Figures figures;
  figures.robot = settings.robot;
  figures.launch_file = settings.launch_file;
  figures.version = settings.version;
  figures.date = local_date(began_at_);
  figures.arguments = settings.arguments;
  figures.seed = settings.seed;
  figures.time_s = time_s_;
  figures.faults = faults_;
  figures.has_truth = path_.has_truth();
  figures.path = path_.samples();
  figures.cpu_percents = load_.cpu_percents();
  figures.rss_mbs = load_.rss_mbs();
  if (!report.is_object()) return figures;
  for (const auto& row : report::rows_of(report["streams"])) {
    auto& stream = figures.streams.emplace_back(stream_figures(row));
    stream.rates_hz = load_.rates_hz(report::stream_key(*row.stream));
    stream.lowest_hz = lowest_of(stream.rates_hz);
    const auto nominal = settings.nominal_hz.find((*row.stream)["name"]);
    if (nominal != settings.nominal_hz.end()) stream.nominal_hz = nominal->second;
  }
  if (const auto& drive = report["drive"]; drive.is_object()) {
    figures.distance_m = number_or_unknown(drive, "distance_m");
    figures.odometry_error = {number_or_unknown(drive, "odometry_error_m"),
                              number_or_unknown(drive, "odometry_error_deg")};
    figures.ekf_error = {number_or_unknown(drive, "ekf_error_m"), number_or_unknown(drive, "ekf_error_deg")};
  }
  figures.command_p50_us = 1e3 * number_or_unknown(report["command_to_wheel_ms"], "p50");
  figures.command_p99_us = 1e3 * number_or_unknown(report["command_to_wheel_ms"], "p99");
  const auto& process = report["process"];
  figures.cpu_percent = number_or_unknown(process, "cpu_percent");
  figures.rss_mb = number_or_unknown(process, "rss_mb");
  return figures;
}

}  // namespace nacelle::drive
