// SPDX-License-Identifier: Apache-2.0
#include "report/run_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace nacelle::report {
namespace {

RunReport sample() {
  RunReport report;
  report.bringup_order = {"camera", "lidar"};
  report.bringup = 812ms;
  report.shutdown_order = {"lidar", "camera"};
  runtime::StreamReport scan;
  scan.name = "/scan";
  scan.type = "sensor_msgs/msg/LaserScan";
  scan.published = 101;
  scan.delivered = 202;
  scan.readers = 2;
  scan.overwritten = 3;
  scan.first = MonotonicTime{1s};
  scan.last = MonotonicTime{11s};
  scan.latency_p50 = 5us;
  scan.latency_p99 = 70us;
  scan.latency_max = 900us;
  scan.handed_over = runtime::HandedOver::AcrossThreads;
  report.streams = {scan};
  report.histograms = {{"/diff_drive", kCommandToWheel, 10, 4ms, 12ms, 13ms}};
  report.process = {12.5, 38.2, 9, {{"control", 0}, {"detector", 44.5}}};
  report.seed = 7;
  return report;
}

TEST(RunReport, has_the_keys_and_units_that_others_read) {
  const auto written = nlohmann::json::parse(to_json(sample()).dump());  // the order of keys does not matter
  EXPECT_EQ(written["bringup"]["order"], (std::vector<std::string>{"camera", "lidar"}));
  EXPECT_EQ(written["bringup"]["ms"], 812.0);
  EXPECT_EQ(written["shutdown"]["order"], (std::vector<std::string>{"lidar", "camera"}));
  const auto& stream = written["streams"][0];
  EXPECT_EQ(stream["name"], "/scan");
  EXPECT_EQ(stream["type"], "sensor_msgs/msg/LaserScan");
  EXPECT_NEAR(stream["hz"].get<double>(), 10.0, 0.11);
  EXPECT_EQ(stream["published"], 101);
  EXPECT_EQ(stream["delivered"], 202);
  EXPECT_EQ(stream["readers"], 2);
  EXPECT_EQ(stream["dropped"], nlohmann::json({{"overwritten", 3}}));
  EXPECT_EQ(stream["copies"], 0);
  EXPECT_EQ(stream["bytes_copied"], 0);
  EXPECT_EQ(stream["latency_us"],
            nlohmann::json({{"p50", 5.0}, {"p99", 70.0}, {"max", 900.0}, {"handed_over", "across threads"}}));
  EXPECT_TRUE(written["drive"].is_null());
  EXPECT_EQ(written["command_to_wheel_ms"], nlohmann::json({{"p50", 4.0}, {"p99", 12.0}}));
  EXPECT_EQ(written["process"]["cpu_percent"], 12.5);
  EXPECT_EQ(written["process"]["rss_mb"], 38.2);
  EXPECT_EQ(written["process"]["threads"], 9);
  EXPECT_EQ(written["process"]["allocations_per_second"], nlohmann::json({{"control", 0.0}, {"detector", 44.5}}));
  EXPECT_EQ(written["seed"], 7);
}

TEST(RunReport, says_null_for_what_was_not_measured) {
  RunReport report = sample();
  report.seed.reset();
  report.histograms[0].count = 0;
  report.drive = DriveFigures{4.0, std::nan(""), 0.01};
  const auto written = nlohmann::json::parse(to_json(report).dump());
  EXPECT_TRUE(written["seed"].is_null());
  EXPECT_TRUE(written["command_to_wheel_ms"]["p99"].is_null());
  EXPECT_TRUE(written["drive"]["odometry_error_m"].is_null());
  EXPECT_EQ(written["drive"]["ekf_error_m"], 0.01);
}

TEST(Summary, shows_every_stream_and_every_thread_that_allocates) {
  RunReport report = sample();
  report.drive = DriveFigures{4.012, 0.0312, 0.0104};
  const std::string text = summary_of(nlohmann::ordered_json::parse(to_json(report).dump()));
  for (const char* const part : {"/scan", "202", "3 overwritten", "odometry 31.2 mm", "EKF 10.4 mm", "detector 44.5/s",
                                 "812 ms: camera lidar", "p99 12.00 ms"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " is not in\n" << text;
  }
}

TEST(Summary, has_the_yaw_errors_if_they_are_known) {
  RunReport report = sample();
  report.drive = DriveFigures{4.012, 0.0312, 0.0104, 0.62, 0.05};
  const auto written = nlohmann::ordered_json::parse(to_json(report).dump());
  EXPECT_EQ(written["drive"]["odometry_error_deg"], 0.62);
  EXPECT_EQ(written["drive"]["ekf_error_deg"], 0.05);
  const std::string text = summary_of(written);
  EXPECT_NE(text.find("odometry 31.2 mm and 0.62 deg, EKF 10.4 mm and 0.05 deg\n"), std::string::npos) << text;
}

TEST(Summary, can_be_made_of_a_report_with_holes) {
  RunReport report;
  report.drive = DriveFigures{1.0, std::nan(""), std::nan("")};
  const std::string text = summary_of(nlohmann::ordered_json::parse(to_json(report).dump()));
  EXPECT_NE(text.find("odometry unknown"), std::string::npos) << text;
  EXPECT_EQ(text.find("deg"), std::string::npos) << text;
  EXPECT_EQ(text.find("heap"), std::string::npos) << text;
}

TEST(Summary, leaves_out_an_unused_type_and_names_the_types_of_two_that_are_used) {
  RunReport report = sample();
  report.streams[0].name = "/cmd_vel";
  report.streams[0].type = "geometry_msgs/msg/Twist";
  report.streams.push_back(report.streams[0]);
  report.streams[1].type = "geometry_msgs/msg/TwistStamped";
  const auto summary = [&] { return summary_of(nlohmann::ordered_json::parse(to_json(report).dump())); };
  EXPECT_NE(summary().find("/cmd_vel Twist "), std::string::npos) << summary();
  EXPECT_NE(summary().find("/cmd_vel TwistStamped "), std::string::npos) << summary();

  report.streams[0].published = 0;
  const std::string text = summary();
  EXPECT_NE(text.find("\n/cmd_vel  "), std::string::npos) << text;
  EXPECT_EQ(text.find("/cmd_vel"), text.rfind("/cmd_vel")) << text;
}

TEST(ReportFile, is_refused_before_the_run_where_it_could_not_be_written) {
  EXPECT_TRUE(check_report_file(::testing::TempDir() + "a_new_report.json"));
  EXPECT_TRUE(check_report_file("/dev/null"));
  EXPECT_EQ(check_report_file("/nosuch/x.json").error().text(),
            "/nosuch/x.json: the report cannot be written: No such file or directory; is the folder there, and yours?");
  EXPECT_FALSE(check_report_file("/tmp"));
}

TEST(ComponentName, is_the_node_s_without_the_root) {
  EXPECT_EQ(component_name("/camera"), "camera");
  EXPECT_EQ(component_name("/robot1/camera"), "robot1/camera");
}

TEST(Summary, of_a_short_run_reports_that_its_cost_was_not_measured) {
  RunReport report = sample();
  report.process.cpu_percent.reset();
  report.process.allocations_per_second.clear();
  const auto written = nlohmann::ordered_json::parse(to_json(report).dump());
  EXPECT_TRUE(written["process"]["cpu_percent"].is_null());
  EXPECT_TRUE(written["process"]["allocations_per_second"].is_null());
  EXPECT_NE(summary_of(written).find("process    CPU not measured: the run was too short, 38.2 MB, 9 threads\n"),
            std::string::npos);
}

}  // namespace
}  // namespace nacelle::report
