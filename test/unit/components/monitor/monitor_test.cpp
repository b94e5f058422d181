// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnostic_msgs/msg/diagnostic_array.hpp"
#include "geometry_msgs/msg/twist.hpp"
#include "geometry_msgs/msg/twist_stamped.hpp"
#include "monitor/component/monitor_component.hpp"
#include "monitor/component/stream_readers.hpp"
#include "monitor/model/stream_watch.hpp"
#include "sensor_msgs/msg/laser_scan.hpp"
#include "std_msgs/msg/string.hpp"
#include "support/allocation_guard.hpp"
#include "support/recording_host.hpp"

namespace nacelle::monitor {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using ::testing::HasSubstr;
using Strings = std::vector<std::string>;

MonotonicTime at(Duration since_start) { return {1000s + since_start}; }

TEST(StreamWatch, measures_the_rate_between_two_looks) {
  StreamWatch watch;
  watch.start(at(0s));
  for (int i = 0; i < 20; ++i) watch.record(at(50ms * i), 1, static_cast<std::uint64_t>(i + 1), {});
  const auto first = watch.look(at(1s), {});
  EXPECT_DOUBLE_EQ(first.rate_hz, 20.0);
  EXPECT_EQ(first.level, Level::Ok);
  EXPECT_EQ(first.message, "20.0 Hz");
  watch.record(at(1500ms), 1, 21, {});
  EXPECT_DOUBLE_EQ(watch.look(at(3s), {}).rate_hz, 0.5);
}

TEST(StreamWatch, counts_gaps_for_each_writer_alone) {
  StreamWatch watch;
  watch.start(at(0s));
  // Two writers take turns; the second one loses its 3 and 4. A stream may be joined in the middle: no gap.
  for (const auto& [writer, sequence] : {std::pair{7, 41}, {9, 1}, {7, 42}, {9, 2}, {9, 5}, {7, 43}}) {
    watch.record(at(10ms), static_cast<std::uint64_t>(writer), static_cast<std::uint64_t>(sequence), {});
  }
  const auto report = watch.look(at(1s), {});
  EXPECT_EQ(report.lost, 2U);
  EXPECT_EQ(report.level, Level::Warn);
  EXPECT_EQ(report.message, "2 messages missing");
  watch.record(at(1100ms), 7, 44, {});
  EXPECT_EQ(watch.look(at(2s), {}).level, Level::Ok) << "a gap is reported once";
}

TEST(StreamWatch, a_pause_is_no_gap) {
  StreamWatch watch;
  watch.start(at(0s));
  watch.record(at(1ms), 1, 1, {});
  watch.start(at(10s));
  watch.record(at(10s), 1, 500, {});
  EXPECT_EQ(watch.look(at(11s), {}).lost, 0U);
}

TEST(StreamWatch, tells_more_writers_than_it_can_hold_without_false_gaps) {
  StreamWatch watch;
  watch.start(at(0s));
  for (std::uint64_t round = 1; round <= 3; ++round) {
    for (std::uint64_t writer = 1; writer <= 40; ++writer) watch.record(at(1ms), writer, round, {});
  }
  const auto report = watch.look(at(1s), {});
  EXPECT_EQ(report.received, 120U);
  EXPECT_EQ(report.lost, 0U);
}

TEST(StreamWatch, judges_by_what_is_expected) {
  const auto level_at = [](int messages, Expectation expected) {
    StreamWatch watch;
    watch.start(at(0s));
    for (int i = 0; i < messages; ++i) watch.record(at(900ms), 1, static_cast<std::uint64_t>(i + 1), 30ms);
    return watch.look(at(1s), expected).level;
  };
  Expectation ten;
  ten.rate_hz = 10;
  EXPECT_EQ(level_at(10, ten), Level::Ok);
  EXPECT_EQ(level_at(11, ten), Level::Ok);
  EXPECT_EQ(level_at(8, ten), Level::Warn);
  EXPECT_EQ(level_at(15, ten), Level::Warn);
  EXPECT_EQ(level_at(4, ten), Level::Error);
  EXPECT_EQ(level_at(0, ten), Level::Stale);
  Expectation young;
  young.most_age = 20ms;
  EXPECT_EQ(level_at(10, young), Level::Warn);
  Expectation command;
  command.periodic = false;
  EXPECT_EQ(level_at(0, command), Level::Ok);
}

TEST(StreamWatch, a_periodic_stream_goes_stale_a_command_does_not) {
  Expectation periodic, command;
  command.periodic = false;
  for (const auto& [expected, level] : {std::pair{periodic, Level::Stale}, {command, Level::Ok}}) {
    StreamWatch watch;
    watch.start(at(0s));
    watch.record(at(1s), 1, 1, {});
    EXPECT_EQ(watch.look(at(2s), expected).level, Level::Ok);
    const auto report = watch.look(at(4s), expected);
    EXPECT_EQ(report.level, level);
    EXPECT_EQ(report.silent_for, Duration{3s});
  }
}

TEST(PlanStream, knows_the_robots_own_topics) {
  for (const char* topic : {"/camera/image_raw", "/camera/camera_info", "/detections", "/scan", "/imu/data_raw",
                            "/imu/data", "/imu/mag", "/cmd_vel", "/joint_states", "/battery/state", "/odom",
                            "/odometry/filtered", "/tf", "/tf_static", "/robot_description", "/diagnostics"}) {
    const auto plan = plan_stream(topic);
    ASSERT_TRUE(plan) << topic;
    EXPECT_EQ(plan.value().topic, topic);
  }
  EXPECT_EQ(plan_stream("/cmd_vel").value().types.size(), 2U);
  EXPECT_EQ(plan_stream("/tf_static").value().qos.durability(), Durability::TransientLocal);
  EXPECT_EQ(plan_stream("/robot_description").value().qos.reliability(), Reliability::Reliable);
  EXPECT_EQ(plan_stream("/scan").value().qos.reliability(), Reliability::BestEffort);
  EXPECT_LE(plan_stream("/camera/image_raw").value().qos.depth(), 5U) << "each image that waits keeps a buffer";
  EXPECT_FALSE(plan_stream("/cmd_vel").value().periodic);
}

TEST(PlanStream, reads_a_type_behind_any_other_topic) {
  const auto plan = plan_stream("  front/scan   sensor_msgs/msg/LaserScan ");
  ASSERT_TRUE(plan) << plan.error().text();
  EXPECT_EQ(plan.value().topic, "front/scan");
  EXPECT_STREQ(plan.value().types.at(0)->name, "sensor_msgs/msg/LaserScan");
}

TEST(PlanStream, says_what_it_does_not_know) {
  EXPECT_THAT(plan_stream("/scann").error().text(), HasSubstr("did you mean '/scan'?"));
  EXPECT_THAT(plan_stream("/front").error().text(), HasSubstr("write it behind the topic"));
  EXPECT_THAT(plan_stream("/a sensor_msgs/msg/LaserScn").error().text(),
              HasSubstr("did you mean 'sensor_msgs/msg/LaserScan'"));
  EXPECT_THAT(plan_stream(" ").error().text(), HasSubstr("empty"));
}

class MonitorComponentTest : public ::testing::TestWithParam<const char*> {
 protected:
  NodeOptions options(Strings streams) {
    return NodeOptions{context}
        .append_parameter_override("streams", std::move(streams))
        .append_parameter_override("share_as", std::string(GetParam()));
  }
  static void start(MonitorComponent& monitor) {
    ASSERT_TRUE(monitor.trigger(Transition::Configure).success);
    ASSERT_TRUE(monitor.trigger(Transition::Activate).success);
  }
  void scan(Duration age) {
    sensor_msgs::msg::LaserScan message;
    const auto stamp = (context.clock().wall_now() - age).nanoseconds();
    message.header.stamp.sec = static_cast<std::int32_t>(stamp / 1'000'000'000);
    message.header.stamp.nanosec = static_cast<std::uint32_t>(stamp % 1'000'000'000);
    context.inject("/scan", message);
  }
  DiagnosticStatus last(const std::string& name) {
    const auto reports = context.published<DiagnosticArray>("/diagnostics");
    if (reports.empty()) return {};
    for (const auto& status : reports.back().status) {
      if (status.name == name) return status;
    }
    return {};
  }
  static std::string value(const DiagnosticStatus& status, const std::string& key) {
    for (const auto& entry : status.values) {
      if (entry.key == key) return entry.value;
    }
    return "(none)";
  }
  test::RecordingContext context;
};

TEST_P(MonitorComponentTest, tells_rate_age_and_gaps_once_a_second) {
  MonitorComponent monitor{options({"/scan"})};
  start(monitor);
  for (int i = 0; i < 10; ++i) {
    scan(25ms);
    context.advance(100ms);
  }
  const auto reports = context.published<DiagnosticArray>("/diagnostics");
  ASSERT_EQ(reports.size(), 1U);
  const auto status = last("monitor: /scan");
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  EXPECT_EQ(value(status, "rate_hz"), "10.00");
  EXPECT_EQ(value(status, "age_ms"), "25.000");
  EXPECT_EQ(value(status, "lost"), "0");
  EXPECT_EQ(value(status, "received"), "10");
  EXPECT_EQ(value(status, "type"), "sensor_msgs/msg/LaserScan");
}

TEST_P(MonitorComponentTest, reads_both_types_of_cmd_vel_and_what_is_sent_once) {
  MonitorComponent monitor{options({"/cmd_vel", "/robot_description"})};
  start(monitor);
  context.inject("/cmd_vel", geometry_msgs::msg::Twist{});
  context.inject("/cmd_vel", geometry_msgs::msg::TwistStamped{});
  context.inject("/robot_description", std_msgs::msg::String{});
  context.advance(1s);
  context.advance(10s);
  EXPECT_EQ(value(last("monitor: /cmd_vel"), "received"), "2");
  EXPECT_EQ(last("monitor: /cmd_vel").level, DiagnosticStatus::OK);
  EXPECT_EQ(last("monitor: /robot_description").level, DiagnosticStatus::OK);
  EXPECT_EQ(value(last("monitor: /robot_description"), "age_ms"), "(none)");
}

TEST_P(MonitorComponentTest, calls_a_silent_sensor_stale) {
  MonitorComponent monitor{options({"/scan"})};
  start(monitor);
  scan(1ms);
  context.advance(4s);
  EXPECT_EQ(last("monitor: /scan").level, DiagnosticStatus::STALE);
}

TEST_P(MonitorComponentTest, holds_rates_against_expectations) {
  MonitorComponent monitor{
      options({"/scan", "/odom"}).append_parameter_override("expected_rates", std::vector<std::int64_t>{30, 0})};
  start(monitor);
  for (int i = 0; i < 10; ++i) {
    scan(1ms);
    context.advance(100ms);
  }
  EXPECT_EQ(last("monitor: /scan").level, DiagnosticStatus::ERROR);
  EXPECT_EQ(last("monitor: /scan").message, "10.0 Hz instead of 30.0");
}

TEST_P(MonitorComponentTest, refuses_parameters_that_make_no_sense) {
  const auto refusal = [&](const NodeOptions& wrong) -> std::string {
    try {
      MonitorComponent monitor{wrong};
    } catch (const exceptions::InvalidParameterValueException& problem) { return problem.what(); }
    return "accepted";
  };
  EXPECT_THAT(refusal(options({"/scann"})),
              HasSubstr("node /monitor, parameter streams: the type of /scann is not known"));
  EXPECT_THAT(refusal(options({"/scan"}).append_parameter_override("share_as", std::string("pointr"))),
              HasSubstr("did you mean 'pointer'"));
  EXPECT_THAT(refusal(options({"/scan"}).append_parameter_override("expected_rates", std::vector<double>{1, 2})),
              HasSubstr("has 2 values for 1 streams"));
  EXPECT_THAT(refusal(options({"/scan"}).append_parameter_override("expected_rates", std::vector<double>{-1})),
              HasSubstr("-1 is not a rate"));
}

TEST_P(MonitorComponentTest, allocates_nothing_per_message) {
  StreamWatch watch;
  watch.start(at(0s));
  const test::AllocationGuard guard;
  for (std::uint64_t i = 1; i <= 1000; ++i) watch.record(at(1ms), i % 5, i, 3ms);
  EXPECT_EQ(guard.count(), 0U);
}

INSTANTIATE_TEST_SUITE_P(ShareAs, MonitorComponentTest, ::testing::Values("reference", "pointer"));

}  // namespace
}  // namespace nacelle::monitor
