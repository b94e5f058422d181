// SPDX-License-Identifier: Apache-2.0
#include "ekf/component/ekf_component.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "ekf_cases.hpp"
#include "ekf_node.hpp"
#include "nacelle/qos/presets.hpp"
#include "support/log_lines.hpp"
#include "support/recording_host.hpp"

namespace nacelle::ekf {
namespace {

using geometry_msgs::msg::PoseWithCovarianceStamped;
using nav_msgs::msg::Odometry;
using sensor_msgs::msg::Imu;
using tf2_msgs::msg::TFMessage;

double yaw_of(const Odometry& m) { return 2.0 * std::atan2(m.pose.pose.orientation.z, m.pose.pose.orientation.w); }

TEST_F(EkfNode, fuses_wheels_and_gyro_and_publishes_once_per_tick) {
  start();
  for (int i = 0; i < 100; ++i) run(0.3, 0.0);
  const auto out = filtered();
  ASSERT_EQ(out.size(), 100U);
  EXPECT_EQ(out.back().header.frame_id, "odom");
  EXPECT_EQ(out.back().child_frame_id, "base_footprint");
  EXPECT_NEAR(out.back().pose.pose.position.x, 0.6, 0.012);
  EXPECT_NEAR(out.back().pose.pose.position.z, 0.0, 1e-6);
  EXPECT_GT(out.back().pose.covariance[0], 0.0);
  EXPECT_EQ(node_->stats("odom0 twist")->fused, 100U);
  EXPECT_EQ(node_->stats("imu0 angular_velocity")->fused, 200U);
  EXPECT_EQ(node_->stats("imu0 orientation"), nullptr);
}

TEST_F(EkfNode, its_stamps_only_grow_and_never_stop) {
  start();
  run(0.3, 0.0);
  for (int i = 0; i < 30; ++i) context_.advance(20ms);  // nothing comes
  for (int i = 0; i < 30; ++i) run(0.3, 0.0);
  const auto out = filtered();
  ASSERT_EQ(out.size(), 61U);
  for (std::size_t i = 1; i < out.size(); ++i)
    EXPECT_GT(time_of(out[i].header.stamp), time_of(out[i - 1].header.stamp)) << i;
}

TEST_F(EkfNode, is_the_first_owner_of_the_transform) {
  start();
  ASSERT_EQ(context_.frames().size(), 1U);
  EXPECT_EQ(context_.frames()[0].parent, "odom");
  EXPECT_EQ(context_.frames()[0].child, "base_footprint");
  EXPECT_EQ(context_.frames()[0].kind, FrameClaimKind::Primary);
  for (int i = 0; i < 10; ++i) run(0.3, 0.2);
  const auto tf = context_.published<TFMessage>("/tf");
  const auto out = filtered();
  ASSERT_EQ(tf.size(), out.size());
  EXPECT_EQ(tf.back().transforms[0].header.stamp, out.back().header.stamp);
  EXPECT_EQ(tf.back().transforms[0].transform.translation.x, out.back().pose.pose.position.x);
}

TEST_F(EkfNode, publish_tf_false_claims_and_sends_nothing) {
  options_.append_parameter_override("publish_tf", false);
  start();
  run(0.3, 0.0);
  EXPECT_TRUE(context_.frames().empty());
  EXPECT_TRUE(context_.published<TFMessage>("/tf").empty());
}

TEST_F(EkfNode, counts_what_has_no_transform_and_fuses_it_once_there_is_one) {
  start();
  context_.advance(20ms);
  send_imu(0.1, "other_imu");
  EXPECT_EQ(node_->stats("imu0 angular_velocity")->of(Rejection::NoTransform), 1U);
  ASSERT_TRUE(buffer_->insert("base_footprint", "other_imu", WallTime{}, {}, spatial::Permanence::Static));
  context_.advance(1ms);
  send_imu(0.1, "other_imu");
  context_.advance(20ms);
  EXPECT_EQ(node_->stats("imu0 angular_velocity")->fused, 1U);
}

TEST_F(EkfNode, an_imu_mounted_upside_down_turns_the_other_way) {
  ASSERT_TRUE(buffer_->insert("base_footprint", "flipped", WallTime{},
                              {spatial::quaternion_from_rpy({spatial::kPi, 0, 0}), {0, 0, 0}},
                              spatial::Permanence::Static));
  start();
  for (int i = 0; i < 50; ++i) {
    context_.advance(20ms);
    send_imu(-0.5, "flipped");
  }
  context_.advance(20ms);
  EXPECT_NEAR(filtered().back().twist.twist.angular.z, 0.5, 1e-3);
}

TEST_F(EkfNode, old_and_impossible_messages_are_counted_by_cause) {
  start();
  run(0.3, 0.0);
  send_odometry(0.3, 0.0, 500ms);
  send_odometry(std::nan(""));
  context_.advance(20ms);
  const PartStats& stats = *node_->stats("odom0 twist");
  EXPECT_EQ(stats.of(Rejection::Stale), 1U);
  EXPECT_EQ(stats.of(Rejection::NotFinite), 1U);
  EXPECT_EQ(stats.received, 3U);
  EXPECT_EQ(stats.fused, 1U);
}

TEST_F(EkfNode, reports_future_stamps_with_the_clock_that_causes_them) {
  const auto skews = std::static_pointer_cast<ClockSkews>(context_.shared_object(kClockSkewsName, &make_clock_skews));
  std::uint64_t writer = 0;
  Node probe{"probe", NodeOptions{context_}};
  const auto listening = probe.create_subscription<Odometry>(
      "/odom", SensorDataQoS(), [&](const Odometry&, const MessageInfo& info) { writer = info.writer_id; });
  start();
  send_odometry(0.3, 0.0, -60s);
  ASSERT_NE(writer, 0U);
  skews->replace({{writer, ClockSkew{"laptop", 60s}}});
  const test::LogLines lines;
  for (int i = 0; i < 500; ++i) {
    context_.advance(10ms);
    if (i % 10 == 0) send_odometry(0.3, 0.0, -60s);
  }
  EXPECT_NE(std::find(lines.all.begin(), lines.all.end(),
                      "odom0 twist is not fused: its stamps lie in the future; clock skew: host laptop is 60 s ahead"),
            lines.all.end())
      << ::testing::PrintToString(lines.all);
}

TEST_F(EkfNode, says_whose_stamps_are_zero_stand_still_or_lag) {
  options_.append_parameter_override("print_diagnostics", true);
  options_.append_parameter_override("odom0", std::string{"odom"});
  options_.append_parameter_override("odom0_config", config_of({kVx}));
  options_.append_parameter_override("odom1", std::string{"odom1"});
  options_.append_parameter_override("odom1_config", config_of({kVx}));
  options_.append_parameter_override("odom2", std::string{"odom2"});
  options_.append_parameter_override("odom2_config", config_of({kVx}));
  start();
  const test::LogLines lines;
  Odometry zero, standing, lagging;
  for (Odometry* m : {&zero, &standing, &lagging}) {
    m->child_frame_id = "base_footprint";
    m->twist.twist.linear.x = 1.0;
    for (std::size_t i = 0; i < 6; ++i) m->twist.covariance[i * 7] = 1e-4;
  }
  standing.header.stamp = stamp();
  for (int i = 0; i < 500; ++i) {
    context_.advance(10ms);
    context_.inject("/odom", zero);
    context_.inject("/odom1", standing);
    lagging.header.stamp = stamp(5s);
    context_.inject("/odom2", lagging);
  }
  const auto told = [&](const std::string& text) {
    return std::count_if(lines.all.begin(), lines.all.end(),
                         [&](const std::string& line) { return line.find(text) != std::string::npos; });
  };
  const std::string all = ::testing::PrintToString(lines.all);
  EXPECT_EQ(told("odom0 twist is not fused: its stamps are zero"), 1) << all;
  EXPECT_EQ(told("odom1 twist: its stamps stand still"), 1) << all;
  EXPECT_EQ(told("odom2 twist: its stamps are 5.0"), 1) << all;
  EXPECT_LT(filtered().back().pose.pose.position.x, 0.5) << "no measurement says that time has passed";
  using diagnostic_msgs::msg::DiagnosticStatus;
  const auto diagnostics = context_.published<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics");
  ASSERT_FALSE(diagnostics.empty());
  for (const auto& status : diagnostics.back().status) EXPECT_EQ(status.level, DiagnosticStatus::WARN) << status.name;
}

TEST_F(EkfNode, says_once_which_input_has_stamps_ahead_among_good_ones) {
  start();
  const test::LogLines lines;
  const auto told = [&](const std::string& text) {
    return std::count_if(lines.all.begin(), lines.all.end(),
                         [&](const std::string& line) { return line.find(text) != std::string::npos; });
  };
  for (int i = 0; i < 500; ++i) {
    context_.advance(10ms);
    send_odometry(0.3, 0.0, i % 10 == 5 ? -5s : 0s);
  }
  const std::string all = ::testing::PrintToString(lines.all);
  EXPECT_EQ(told("odom0 twist: "), 1) << all;
  EXPECT_EQ(told("stamps lie in the future; these measurements are not fused"), 1) << all;
  for (int i = 0; i < 300; ++i) {
    context_.advance(10ms);
    send_odometry(0.3);
  }
  EXPECT_EQ(told("odom0 twist: its stamps no longer lie in the future"), 1) << ::testing::PrintToString(lines.all);
}

TEST_F(EkfNode, measurements_that_the_queues_lose_are_counted_and_reported) {
  options_.append_parameter_override("measurement_queue_limit", std::int64_t{16});
  start();
  const test::LogLines lines;
  for (int second = 0; second < 3; ++second) {
    for (int i = 0; i < 40; ++i) send_odometry(0.3, 0.0, -150ms);  // ahead: they wait, and there is room for 16
    context_.advance(1s);
  }
  EXPECT_GT(node_->stats("odom0 twist")->of(Rejection::QueueFull), 0U);
  EXPECT_TRUE(std::any_of(lines.all.begin(), lines.all.end(), [](const std::string& line) {
    return line.find("odom0: ") != std::string::npos && line.find("measurement_queue_limit") != std::string::npos;
  })) << ::testing::PrintToString(lines.all);
}

TEST_F(EkfNode, accelerations_of_an_imu_off_the_origin_leave_the_speed_alone_when_stamps_are_4_us_apart) {
  const unsigned seed = 53;
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  options_.append_parameter_override("odom0", std::string{"odom"});
  options_.append_parameter_override("odom0_config", config_of({kVx, kVy, kVyaw}));
  options_.append_parameter_override("imu0", std::string{"imu/data_raw"});
  options_.append_parameter_override("imu0_config", config_of({kVyaw, kAx, kAy}));
  ASSERT_TRUE(buffer_->insert("base_footprint", "bumper", WallTime{}, {Eigen::Quaterniond::Identity(), {0.3, 0.2, 0.0}},
                              spatial::Permanence::Static));
  start();
  Imu imu;
  imu.header.frame_id = "bumper";
  imu.orientation_covariance[0] = -1.0;
  for (std::size_t i = 0; i < 9; i += 4) {
    imu.angular_velocity_covariance[i] = 3e-6;
    imu.linear_acceleration_covariance[i] = 1e-2;
  }

  for (int i = 0; i < 250; ++i) {
    context_.advance(19ms);
    send_odometry(1.0, 0.01 * normal(random));
    imu.header.stamp = stamp(-4us);
    imu.angular_velocity.z = 0.0017 * normal(random);
    imu.linear_acceleration.x = 0.1 * normal(random);
    imu.linear_acceleration.y = 0.1 * normal(random);
    context_.inject("/imu/data_raw", imu);
    context_.advance(1ms);
  }

  EXPECT_EQ(node_->stats("imu0 linear_acceleration")->fused, 250U);
  for (const Odometry& out : filtered()) {
    ASSERT_NEAR(out.twist.twist.linear.x, 1.0, 0.1) << "seed " << seed;
    ASSERT_NEAR(out.twist.twist.linear.y, 0.0, 0.1) << "seed " << seed;
  }
}

TEST_F(EkfNode, disabled_at_startup_waits_for_the_service_enable) {
  options_.append_parameter_override("disabled_at_startup", true);
  start();
  for (int i = 0; i < 10; ++i) run(0.3, 0.0);
  EXPECT_TRUE(filtered().empty());
  EXPECT_EQ(node_->stats("odom0 twist")->received, 0U);
  std_srvs::srv::Empty::Response response;
  ASSERT_TRUE(context_.call<std_srvs::srv::Empty>("/enable", {}, response));
  for (int i = 0; i < 10; ++i) run(0.3, 0.0);
  EXPECT_EQ(filtered().size(), 10U);
}

TEST_F(EkfNode, base_link_frame_output_is_what_messages_and_the_transform_call_the_base) {
  options_.append_parameter_override("base_link_frame_output", std::string{"base_stabilised"});
  options_.append_parameter_override("publish_acceleration", true);
  start();
  run(0.3, 0.0);
  EXPECT_EQ(node_->stats("odom0 twist")->fused, 1U) << "inputs are still in base_link_frame";
  EXPECT_EQ(filtered().back().child_frame_id, "base_stabilised");
  EXPECT_EQ(context_.published<TFMessage>("/tf").back().transforms[0].child_frame_id, "base_stabilised");
  EXPECT_EQ(context_.frames()[0].child, "base_stabilised");
  using Acceleration = geometry_msgs::msg::AccelWithCovarianceStamped;
  EXPECT_EQ(context_.published<Acceleration>("/accel/filtered").back().header.frame_id, "base_stabilised");
}

TEST_F(EkfNode, use_control_predicts_with_what_cmd_vel_commands) {
  for (const bool stamped : {false, true}) {
    test::RecordingContext context;
    NodeOptions options{context};
    options.append_parameter_override("use_control", true);
    options.append_parameter_override("stamped_control", stamped);
    options.append_parameter_override("control_timeout", 0.2);
    options.append_parameter_override("control_config", std::vector<bool>{true, false, false, false, false, true});
    EkfComponent node{options};
    ASSERT_TRUE(node.trigger(Transition::Configure).success);
    const auto announced = context.announced("/cmd_vel");
    ASSERT_EQ(announced.size(), 1U);
    EXPECT_EQ(announced[0].second, Announced::WithItsPublisher) << "the base may read another type there";
    ASSERT_TRUE(node.trigger(Transition::Activate).success);
    Odometry still;
    still.header.stamp = context.clock().wall_now();
    still.child_frame_id = "base_link";
    for (std::size_t i = 0; i < 6; ++i) still.twist.covariance[i * 7] = 1e-4;
    context.inject("/odom", still);
    for (int i = 0; i < 40; ++i) {
      geometry_msgs::msg::TwistStamped command;
      command.header.stamp = context.clock().wall_now();
      command.header.frame_id = i % 2 == 0 ? "base_link" : "";
      command.twist.linear.x = 0.5;
      if (stamped) {
        context.inject("/cmd_vel", command);
      } else {
        context.inject("/cmd_vel", command.twist);
      }
      context.advance(50ms);
    }
    const double v = context.published<Odometry>("/odometry/filtered").back().twist.twist.linear.x;
    EXPECT_NEAR(v, 0.5 * (1.0 - std::exp(-2.0)), 0.03) << stamped;
  }
}

TEST_F(EkfNode, set_pose_works_as_a_topic_and_as_a_service) {
  start();
  for (int i = 0; i < 10; ++i) run(0.0, 0.0);
  PoseWithCovarianceStamped told;
  told.header.stamp = stamp();
  told.header.frame_id = "odom";
  told.pose.pose.position.x = 5.0;
  told.pose.pose.orientation.z = std::sin(0.5);
  told.pose.pose.orientation.w = std::cos(0.5);
  for (std::size_t i = 0; i < 6; ++i) told.pose.covariance[i * 7] = 1e-4;
  context_.inject("/set_pose", told);
  run(0.0, 0.0);
  EXPECT_NEAR(filtered().back().pose.pose.position.x, 5.0, 1e-6);
  EXPECT_NEAR(yaw_of(filtered().back()), 1.0, 1e-3);

  robot_localization::srv::SetPose::Request request;
  request.pose = told;
  request.pose.header.stamp = stamp();
  request.pose.pose.pose.position.x = -2.0;
  robot_localization::srv::SetPose::Response response;
  ASSERT_TRUE(context_.call<robot_localization::srv::SetPose>("/set_pose", request, response));
  run(0.0, 0.0);
  EXPECT_NEAR(filtered().back().pose.pose.position.x, -2.0, 1e-6);
}

TEST_F(EkfNode, a_map_filter_broadcasts_what_is_left_between_map_and_odom) {
  options_.append_parameter_override("world_frame", std::string{"map"});
  options_.append_parameter_override("pose0", std::string{"gps"});
  options_.append_parameter_override(
      "pose0_config", std::vector<bool>{true, true, false, false, false, true, false, false, false, false, false, false,
                                        false, false, false});
  start();
  ASSERT_TRUE(buffer_->insert("odom", "base_footprint", context_.clock().wall_now(),
                              spatial::RigidTransform::planar(1, 0, 0), spatial::Permanence::Dynamic));
  PoseWithCovarianceStamped fix;
  fix.header.stamp = stamp();
  fix.header.frame_id = "map";
  fix.pose.pose.position.x = 3.0;
  fix.pose.pose.orientation.w = 1.0;
  for (std::size_t i = 0; i < 6; ++i) fix.pose.covariance[i * 7] = 1e-4;
  context_.inject("/gps", fix);
  context_.advance(20ms);
  const auto tf = context_.published<TFMessage>("/tf");
  ASSERT_EQ(tf.size(), 1U);
  EXPECT_EQ(tf[0].transforms[0].header.frame_id, "map");
  EXPECT_EQ(tf[0].transforms[0].child_frame_id, "odom");
  EXPECT_NEAR(tf[0].transforms[0].transform.translation.x, 2.0, 1e-6);
}

TEST_F(EkfNode, diagnostics_hold_the_counters_once_a_second) {
  options_.append_parameter_override("print_diagnostics", true);
  start();
  for (int i = 0; i < 110; ++i) run(0.3, 0.0);
  const auto all = context_.published<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics");
  ASSERT_EQ(all.size(), 2U);
  ASSERT_EQ(all.back().status.size(), 2U);
  EXPECT_EQ(all.back().status[0].name, "ekf: odom0 twist");
  EXPECT_EQ(all.back().status[0].values[1].key, "fused");
}

// A square metre as the simulated robot drives it: radii off by 0.3 %, track by 1 %, a gyro bias left after calibration.
TEST_F(EkfNode, beats_the_wheels_on_a_square) {
  const unsigned seed = 51;
  std::mt19937 random{seed};
  std::normal_distribution<double> normal;
  start();
  double ekf_worst = 0.0;
  double x = 0, y = 0, yaw = 0, wx = 0, wy = 0, wyaw = 0;
  const double left = 1.003, right = 0.997, track = 1.01 * 0.3;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < 250; ++i) {
      const double v = i < 170 ? 0.3 * std::min({1.0, i / 10.0, (170 - i) / 10.0}) : 0.0;
      const double w = i >= 180 ? spatial::kPi / 2 / 1.4 : 0.0;
      const double vl = v - 0.15 * w, vr = v + 0.15 * w;  // what the encoders say
      const double tv = 0.5 * (vl * left + vr * right), tw = (vr * right - vl * left) / track;
      x += 0.02 * tv * std::cos(yaw + 0.01 * tw);
      y += 0.02 * tv * std::sin(yaw + 0.01 * tw);
      yaw += 0.02 * tw;
      wx += 0.02 * v * std::cos(wyaw + 0.01 * w);
      wy += 0.02 * v * std::sin(wyaw + 0.01 * w);
      wyaw += 0.02 * w;
      context_.advance(9ms);
      send_imu(tw + 0.0017 * normal(random));
      context_.advance(9ms);
      send_imu(tw + 0.0017 * normal(random));
      send_odometry(v, w);
      context_.advance(2ms);
    }
    const auto out = filtered().back();
    ekf_worst = std::max(ekf_worst, std::hypot(out.pose.pose.position.x - x, out.pose.pose.position.y - y));
  }
  EXPECT_GT(std::hypot(wx - x, wy - y), 0.02) << "a world without error proves nothing";
  EXPECT_LT(ekf_worst, 0.04) << "seed " << seed;
}

TEST_F(EkfNode, the_same_inputs_give_the_same_outputs_bit_by_bit) {
  const auto drive = [] {
    test::RecordingContext context;
    NodeOptions options{context};
    EkfComponent node{options};
    EXPECT_TRUE(node.trigger(Transition::Configure).success);
    EXPECT_TRUE(node.trigger(Transition::Activate).success);
    std::mt19937 random{52};
    std::normal_distribution<double> normal;
    for (int i = 0; i < 200; ++i) {
      Odometry m;
      m.header.stamp = context.clock().wall_now();
      m.child_frame_id = "base_link";
      m.twist.twist.linear.x = normal(random);
      for (std::size_t k = 0; k < 6; ++k) m.twist.covariance[k * 7] = 1e-3;
      context.inject("/odom", m);
      context.advance(11ms);
    }
    return context.published<Odometry>("/odometry/filtered");
  };
  EXPECT_EQ(drive(), drive());
}

TEST_F(EkfNode, a_wrong_parameter_is_named_with_the_node) {
  options_.append_parameter_override("process_noise_covariance", std::vector<double>(7, 1.0));
  EkfComponent node{options_};
  const auto outcome = node.trigger(Transition::Configure);
  EXPECT_FALSE(outcome.success);
  for (const char* word : {"/ekf", "process_noise_covariance", "15", "36", "225"}) {
    EXPECT_NE(outcome.reason.find(word), std::string::npos) << outcome.reason;
  }
}

}  // namespace
}  // namespace nacelle::ekf
