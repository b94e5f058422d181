// SPDX-License-Identifier: Apache-2.0
// The node with smooth_lagged_data, and without where it would help.
#include <gtest/gtest.h>

#include <algorithm>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include "ekf/component/history_options.hpp"
#include "ekf_cases.hpp"
#include "ekf_node.hpp"
#include "support/log_lines.hpp"

namespace nacelle::ekf {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using testing::PrintToString;

/// Wheels of 50 Hz and poses of 10 Hz that come 0.35 s late.
class EkfLate : public EkfNode {
 public:
  EkfLate() {
    options_.append_parameter_override("odom0", std::string{"odom"});
    options_.append_parameter_override("odom0_config", config_of({kVx, kVyaw}));
    options_.append_parameter_override("pose0", std::string{"pose"});
    options_.append_parameter_override("pose0_config", config_of({kX, kY}));
    options_.append_parameter_override("print_diagnostics", true);
  }
  void smooth(double history_s) {
    options_.append_parameter_override("smooth_lagged_data", true);
    options_.append_parameter_override("history_length", history_s);
  }
  void send_pose(double x, Duration ago) {
    PoseWithCovarianceStamped m;
    m.header.stamp = stamp(ago);
    m.header.frame_id = "odom";
    m.pose.pose.position.x = x;
    m.pose.pose.orientation.w = 1.0;
    for (std::size_t i = 0; i < 6; ++i) m.pose.covariance[i * 7] = 1e-4;
    context_.inject("/pose", m);
  }
  /// Straight on at 0.5 m/s, `steps` times 20 ms.
  void drive(int steps, Duration late) {
    for (int i = 0; i < steps; ++i, ++driven_) {
      context_.advance(18ms);
      send_odometry(0.5);
      // The wheels' first message is of 18 ms.
      if (driven_ % 5 == 0 && driven_ * 20ms > late) send_pose(0.5 * (0.02 * driven_ - to_seconds(late)), late);
      context_.advance(2ms);
    }
  }
  static bool says(const test::LogLines& lines, std::string_view text) { return count(lines, text) > 0; }
  static std::ptrdiff_t count(const test::LogLines& lines, std::string_view text) {
    return std::count_if(lines.all.begin(), lines.all.end(),
                         [&](const std::string& line) { return line.find(text) != std::string::npos; });
  }
  /// Of the last message on /diagnostics.
  std::string diagnosed(std::string_view status, std::string_view key) {
    const auto all = context_.published<DiagnosticArray>("/diagnostics");
    if (all.empty()) return "nothing is published";
    for (const auto& s : all.back().status) {
      if (s.name != status) continue;
      for (const auto& pair : s.values) {
        if (pair.key == key) return pair.value;
      }
    }
    return "no such key";
  }

 private:
  int driven_ = 0;
};

TEST_F(EkfLate, smooth_lagged_data_puts_late_poses_into_their_place) {
  smooth(1.0);
  const test::LogLines lines;
  start();
  drive(400, 350ms);
  EXPECT_TRUE(says(lines, "late measurements go back up to 1 s: room for ")) << PrintToString(lines.all);
  EXPECT_NEAR(filtered().back().pose.pose.position.x, 0.5 * 399 * 0.02, 0.002);
  const PartStats& poses = *node_->stats("pose0 pose");
  EXPECT_GT(poses.fused, 70U);
  EXPECT_EQ(poses.late, poses.fused);
  EXPECT_EQ(filtered().size(), 400U);
  EXPECT_NE(diagnosed("ekf: history", "replays"), "0");
  EXPECT_EQ(diagnosed("ekf: history", "cut_short"), "0");
  EXPECT_FALSE(says(lines, "come 0.3"));
}

TEST_F(EkfLate, without_it_they_pull_the_robot_back_and_the_log_says_what_would_help) {
  const test::LogLines lines;
  start();
  drive(400, 350ms);
  EXPECT_LT(filtered().back().pose.pose.position.x, 0.5 * 399 * 0.02 - 0.05);
  EXPECT_EQ(count(lines, "pose0 pose: its measurements come 0.3"), 1) << PrintToString(lines.all);
  EXPECT_TRUE(says(lines, "smooth_lagged_data: true with history_length: 0.5 puts them into their place"))
      << PrintToString(lines.all);
  EXPECT_EQ(diagnosed("ekf: history", "replays"), "no such key");
}

TEST_F(EkfLate, a_short_delay_is_no_reason_for_a_warning) {
  const test::LogLines lines;
  start();
  drive(400, 15ms);
  EXPECT_FALSE(says(lines, "smooth_lagged_data")) << PrintToString(lines.all);
}

TEST_F(EkfLate, what_is_older_than_the_history_is_reported_once_by_name) {
  options_.append_parameter_override("pose1", std::string{"pose1"});
  options_.append_parameter_override("pose1_config", config_of({kX}));
  smooth(0.4);
  start();
  const test::LogLines lines;
  for (int i = 0; i < 300; ++i) {
    drive(1, 0ms);
    PoseWithCovarianceStamped m;
    // They fall back slowly, so that their own stamps never do.
    const Duration late = 100ms + 3ms * (i % 200);
    m.header.stamp = stamp(late);
    m.pose.pose.orientation.w = 1.0;
    m.pose.covariance[0] = 1.0;
    context_.inject("/pose1", m);
  }
  const PartStats& poses = *node_->stats("pose1 pose");
  EXPECT_GT(poses.of(Rejection::BeforeHistory), 50U);
  EXPECT_GT(poses.fused, 150U);
  EXPECT_EQ(count(lines, "pose1 pose: "), 1) << PrintToString(lines.all);
  EXPECT_EQ(count(lines, "were older than the history (0.4 s)"), 1) << PrintToString(lines.all);
  context_.advance(1s);
  EXPECT_EQ(diagnosed("ekf: pose1 pose", "rejected_before_history"),
            std::to_string(poses.of(Rejection::BeforeHistory)));
}

TEST_F(EkfLate, a_time_that_jumps_back_resets_the_filter_where_it_is_told_to) {
  options_.append_parameter_override("use_sim_time", true);
  options_.append_parameter_override("reset_on_time_jump", true);
  start();
  drive(100, 0ms);
  ASSERT_GT(filtered().back().pose.pose.position.x, 0.9);
  const test::LogLines lines;
  context_.clock().step_wall(-60s);
  context_.advance(20ms);
  send_odometry(0.5);
  context_.advance(20ms);
  EXPECT_EQ(count(lines, "the time jumped back: reset to the initial state"), 1) << PrintToString(lines.all);
  EXPECT_LT(filtered().back().pose.pose.position.x, 0.1);
}

TEST_F(EkfLate, parameters_that_go_together_badly_are_told_before_the_start) {
  const auto warnings = [this] {
    const auto faults = std::make_shared<ParameterFaults>();
    options_.collect_parameter_faults(faults);
    node_ = std::make_unique<EkfComponent>(options_);
    std::string all;
    auto locked = faults->lock();
    for (const ParameterFault& fault : *locked) all += (fault.is_warning ? fault.problem.text() : "error") + "\n";
    return all;
  };
  EXPECT_EQ(warnings(), "");
  options_.append_parameter_override("history_length", 1.0);
  EXPECT_NE(warnings().find("smooth_lagged_data is false"), std::string::npos);
  options_.append_parameter_override("smooth_lagged_data", true);
  options_.append_parameter_override("history_length", 0.0);
  options_.append_parameter_override("reset_on_time_jump", true);
  const std::string text = warnings();
  EXPECT_NE(text.find("no late measurement is fused"), std::string::npos) << text;
  EXPECT_NE(text.find("without use_sim_time"), std::string::npos) << text;
}

}  // namespace
}  // namespace nacelle::ekf
