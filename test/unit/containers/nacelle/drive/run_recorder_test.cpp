// SPDX-License-Identifier: Apache-2.0
#include "drive/run_recorder.hpp"

#include <gmock/gmock.h>

#include <cmath>

namespace nacelle::drive {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr MonotonicTime kBegin{100s};
constexpr WallTime kBeganAt{1'795'878'245s};

RunRecorder recorder_without_truth() { return {"/nosuch/truth", std::nullopt, kBegin, kBeganAt}; }

json stats_at(Duration since_begin) {
  const double seconds = to_seconds(since_begin);
  return {
      {"phase", "running"},
      {"cpu_s", 3.0 + 0.25 * seconds},
      {"rss_mb", 24.5},
      {"nodes", {{{"name", "camera"}, {"state", "active"}}}},
      {"streams",
       {{{"name", "/scan"}, {"type", "sensor_msgs/msg/LaserScan"}, {"published", 10 + std::lround(10 * seconds)}}}}};
}

ordered_json container_report() {
  return ordered_json::parse(R"({
    "streams": [{"name": "/scan", "type": "sensor_msgs/msg/LaserScan", "hz": 9.99, "published": 61, "copies": 2,
                 "dropped": {"full": 3, "overwritten": 4}, "latency_us": {"p50": 20, "p99": 90, "max": 1200}}],
    "drive": {"distance_m": 4.04, "odometry_error_m": 0.021, "ekf_error_m": null, "odometry_error_deg": 1.5, "ekf_error_deg": null},
    "command_to_wheel_ms": {"p50": 4.5, "p99": null},
    "process": {"cpu_percent": null, "rss_mb": 24.6}})");
}

control::TransformAnswer transform(double x_m) {
  control::TransformAnswer X;
  X.known = true;
  X.stamp = kBeganAt;
  X.translation_m = {x_m, 0, 0};
  return X;
}

TEST(RunRecorder, takes_figures_of_streams_from_the_samples_and_from_the_report) {
  RunRecorder recorder = recorder_without_truth();
  for (int i = 0; i <= 20; ++i) recorder.note_stats(stats_at(i * 250ms), kBegin + i * 250ms);
  DriveSettings settings;
  settings.nominal_hz["/scan"] = 10;
  const auto figures = recorder.figures(container_report(), settings);
  ASSERT_EQ(figures.streams.size(), 1U);
  const auto& scan = figures.streams[0];
  EXPECT_EQ(scan.name, "/scan");
  EXPECT_EQ(scan.nominal_hz, 10);
  EXPECT_EQ(scan.hz, 9.99);
  EXPECT_NEAR(scan.lowest_hz, 10, 0.5);
  EXPECT_EQ(scan.published, 61U);
  EXPECT_EQ(scan.dropped, 7U);
  EXPECT_EQ(scan.copies, 2U);
  EXPECT_EQ(scan.max_us, 1200);
  EXPECT_NEAR(figures.cpu_percents.back().value, 25, 1e-6);
  EXPECT_EQ(figures.rss_mbs.size(), 21U);
  EXPECT_DOUBLE_EQ(figures.time_s, 5.0);
}

TEST(RunRecorder, keeps_what_the_report_does_not_know_unknown) {
  const auto figures = recorder_without_truth().figures(container_report(), {});
  EXPECT_EQ(figures.distance_m, 4.04);
  EXPECT_EQ(figures.odometry_error.distance_m, 0.021);
  EXPECT_EQ(figures.odometry_error.yaw_deg, 1.5);
  EXPECT_TRUE(std::isnan(figures.ekf_error.distance_m));
  EXPECT_EQ(figures.command_p50_us, 4500);
  EXPECT_TRUE(std::isnan(figures.command_p99_us));
  EXPECT_TRUE(std::isnan(figures.cpu_percent));
  EXPECT_TRUE(std::isnan(figures.streams[0].nominal_hz));
  EXPECT_TRUE(std::isnan(figures.streams[0].lowest_hz));
  EXPECT_FALSE(figures.has_truth);
  EXPECT_TRUE(recorder_without_truth().figures(nullptr, {}).streams.empty());
}

TEST(RunRecorder, notes_each_fault_once) {
  RunRecorder recorder = recorder_without_truth();
  json stats = stats_at(0s);
  stats["nodes"] = {{{"name", "lidar"}, {"fault", "DEVICE_LOST: it is gone"}},
                    {{"name", "imu"}, {"open_faults", {"SILENT: nothing comes", "SECOND: not shown"}}}};
  for (int i = 0; i < 3; ++i) recorder.note_stats(stats, kBegin + i * 250ms);
  EXPECT_THAT(recorder.figures(nullptr, {}).faults,
              testing::ElementsAre("component lidar: is faulted: DEVICE_LOST: it is gone",
                                   "component imu: has an open fault: SILENT: nothing comes"));
}

TEST(RunRecorder, takes_ten_poses_a_second_of_fifty) {
  RunRecorder recorder = recorder_without_truth();
  for (int i = 0; i < 100; ++i) recorder.note_pose(transform(i * 0.01), kBegin + i * 20ms, kBeganAt + i * 20ms);
  const auto path = recorder.figures(nullptr, {}).path;
  ASSERT_EQ(path.size(), 20U);
  EXPECT_NEAR(path[1].time_s, 0.1, 1e-9);
  EXPECT_NEAR(path[1].ekf.x_m, 0.05, 1e-9);
  EXPECT_TRUE(std::isnan(path[1].odometry.x_m));
}

}  // namespace
}  // namespace nacelle::drive
