// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <robot_localization/srv/toggle_filter_processing.hpp>

#include "ekf_cases.hpp"
#include "ekf_node.hpp"
#include "support/log_lines.hpp"

namespace nacelle::ekf {
namespace {

using Acceleration = geometry_msgs::msg::AccelWithCovarianceStamped;
using Toggle = robot_localization::srv::ToggleFilterProcessing;

class EkfModes : public EkfNode {
 public:
  bool toggle(bool on) {
    Toggle::Request request;
    request.on = on;
    Toggle::Response response;
    EXPECT_TRUE(context_.call<Toggle>("/toggle", request, response));
    return response.status;
  }
  static geometry_msgs::msg::PoseWithCovarianceStamped pose(double x, double yaw, WallTime at, const char* frame) {
    geometry_msgs::msg::PoseWithCovarianceStamped m;
    m.header.stamp = at;
    m.header.frame_id = frame;
    m.pose.pose.position.x = x;
    m.pose.pose.orientation.z = std::sin(0.5 * yaw);
    m.pose.pose.orientation.w = std::cos(0.5 * yaw);
    for (std::size_t i = 0; i < 6; ++i) m.pose.covariance[i * 7] = 1e-4;
    return m;
  }
};

TEST_F(EkfModes, toggle_holds_the_estimate_and_goes_on_without_a_jump) {
  start();
  for (int i = 0; i < 50; ++i) run(0.3, 0.0);
  const auto before = filtered().back();
  EXPECT_FALSE(toggle(true)) << "it is on";
  EXPECT_TRUE(toggle(false));
  EXPECT_FALSE(toggle(false));
  for (int i = 0; i < 100; ++i) run(0.3, 0.0);
  const auto held = filtered().back();
  EXPECT_EQ(filtered().size(), 150U) << "it is published on";
  EXPECT_EQ(held.pose.pose, before.pose.pose);
  EXPECT_EQ(held.pose.covariance, before.pose.covariance);
  EXPECT_EQ(time_of(held.header.stamp), context_.clock().wall_now());
  EXPECT_EQ(node_->stats("odom0 twist")->received, 50U);
  EXPECT_TRUE(toggle(true));
  for (int i = 0; i < 50; ++i) run(0.3, 0.0);
  EXPECT_NEAR(filtered().back().pose.pose.position.x, held.pose.pose.position.x + 0.3, 0.01)
      << "what was driven meanwhile is not made up for";
}

TEST_F(EkfModes, a_differential_input_does_not_see_the_motion_while_toggled_off) {
  options_.append_parameter_override("pose0", std::string{"slam"});
  options_.append_parameter_override("pose0_config", config_of({kX, kY, kYaw}));
  options_.append_parameter_override("pose0_differential", true);
  start();
  double x = 0.0;
  const auto drive = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      context_.inject("/slam", pose(x += 0.01, 0.0, context_.clock().wall_now(), "odom"));
      context_.advance(20ms);
    }
  };
  drive(50);
  EXPECT_TRUE(toggle(false));
  x += 100.0;
  context_.advance(1s);
  EXPECT_TRUE(toggle(true));
  drive(50);
  EXPECT_NEAR(filtered().back().twist.twist.linear.x, 0.5, 0.05);
  EXPECT_LT(filtered().back().pose.pose.position.x, 1.5);
}

TEST_F(EkfModes, toggled_off_before_the_first_measurement_nothing_is_published) {
  start();
  EXPECT_TRUE(toggle(false));
  for (int i = 0; i < 10; ++i) run(0.3, 0.0);
  EXPECT_TRUE(filtered().empty());
  EXPECT_TRUE(toggle(true));
  for (int i = 0; i < 10; ++i) run(0.3, 0.0);
  EXPECT_EQ(filtered().size(), 10U);
}

TEST_F(EkfModes, accel_filtered_has_linear_and_angular_accelerations) {
  options_.append_parameter_override("publish_acceleration", true);
  options_.append_parameter_override("imu0", std::string{"imu/data_raw"});
  options_.append_parameter_override("imu0_config", config_of({kVyaw, kAx}));
  start();
  const int ticks = 200;
  for (int i = 0; i < ticks; ++i) {
    context_.advance(19ms);
    sensor_msgs::msg::Imu m;
    m.header.stamp = stamp();
    m.header.frame_id = "base_footprint";
    m.orientation_covariance[0] = -1.0;
    m.angular_velocity.z = 0.02 * 0.5 * i;  // grows by 0.5 rad/s^2
    m.linear_acceleration.x = 0.25;
    for (std::size_t k = 0; k < 9; k += 4)
      m.angular_velocity_covariance[k] = m.linear_acceleration_covariance[k] = 1e-6;
    context_.inject("/imu/data_raw", m);
    context_.advance(1ms);
  }
  const auto all = context_.published<Acceleration>("/accel/filtered");
  ASSERT_EQ(all.size(), static_cast<std::size_t>(ticks));
  EXPECT_EQ(all.back().header.stamp, filtered().back().header.stamp);
  EXPECT_NEAR(all.back().accel.accel.linear.x, 0.25, 1e-2);
  EXPECT_NEAR(all.back().accel.accel.angular.z, 0.5, 0.02);
  const double rate_variance = filtered().back().twist.covariance[35];
  EXPECT_NEAR(all.back().accel.covariance[35], 2.0 * 50.0 * 50.0 * rate_variance, 1e-9);
  EXPECT_GT(all.back().accel.covariance[0], 0.0);
  EXPECT_EQ(all.back().accel.covariance[3], 0.0) << "linear and angular parts are taken as independent";
}

TEST_F(EkfModes, predict_to_current_time_gives_the_time_of_the_tick) {
  options_.append_parameter_override("predict_to_current_time", true);
  start();
  for (int i = 0; i < 50; ++i) {
    context_.advance(10ms);
    send_odometry(0.5, 0.0, 15ms);  // the driver's delay
    context_.advance(10ms);
  }
  EXPECT_EQ(time_of(filtered().back().header.stamp), context_.clock().wall_now());
  EXPECT_EQ(node_->stats("odom0 twist")->fused, 50U);
}

/// Two filters in one container, as users of robot_localization run them: wheels in odom, wheels and a positioning system in map.
class TwoFilters : public EkfModes {
 public:
  TwoFilters() {
    map_options_.node_namespace("/global");
    map_options_.append_parameter_override("frequency", 50.0);
    map_options_.append_parameter_override("two_d_mode", true);
    map_options_.append_parameter_override("base_link_frame", std::string{"base_footprint"});
    map_options_.append_parameter_override("world_frame", std::string{"map"});
    map_options_.append_parameter_override("odom0", std::string{"/odom"});
    map_options_.append_parameter_override("odom0_config", config_of({kVx, kVyaw}));
    map_options_.append_parameter_override("pose0", std::string{"/fix"});
    map_options_.append_parameter_override("pose0_config", config_of({kX, kY, kYaw}));
  }
  void start_both() {
    start();
    map_ = std::make_unique<EkfComponent>(map_options_);
    ASSERT_TRUE(map_->trigger(Transition::Configure).success);
    ASSERT_TRUE(map_->trigger(Transition::Activate).success);
  }
  /// What the container's listener does with /tf.
  void hear_transforms() {
    const auto all = context_.published<tf2_msgs::msg::TFMessage>("/tf");
    for (; heard_ < all.size(); ++heard_) {
      for (const auto& t : all[heard_].transforms) {
        const auto& r = t.transform.rotation;
        const auto& p = t.transform.translation;
        ASSERT_TRUE(buffer_->insert(t.header.frame_id, t.child_frame_id, time_of(t.header.stamp),
                                    {Eigen::Quaterniond{r.w, r.x, r.y, r.z}, {p.x, p.y, p.z}},
                                    spatial::Permanence::Dynamic));
      }
    }
  }
  /// 20 ms on a circle; the truth begins at (5, 0, 1) in the map.
  void drive(double v, double w) {
    // The velocities are those at the end of a step; a filter moves on with them in the next one.
    truth_ = truth_ * RigidTransform::planar(0.02 * v_, 0.0, 0.02 * w_);
    v_ = v;
    w_ = w;
    context_.advance(19ms);
    send_imu(w);
    send_odometry(v, w);
    auto fix = pose(truth_.translation_m.x(), spatial::yaw_from_quaternion(truth_.rotation),
                    context_.clock().wall_now(), "map");
    fix.pose.pose.position.y = truth_.translation_m.y();
    context_.inject("/fix", fix);
    context_.advance(1ms);
    hear_transforms();
  }

  NodeOptions map_options_{context_};
  std::unique_ptr<EkfComponent> map_;
  RigidTransform truth_ = RigidTransform::planar(5.0, 0.0, 1.0);
  double v_{0.0}, w_{0.0};
  std::size_t heard_{0};
};

TEST_F(TwoFilters, map_to_odom_to_base_is_the_robot_in_the_map) {
  start_both();
  ASSERT_EQ(context_.frames().size(), 2U);
  for (int i = 0; i < 150; ++i) drive(0.5, 0.4);
  const auto X_MO = buffer_->lookup_latest("map", "odom");
  const auto X_OB = buffer_->lookup_latest("odom", "base_footprint");
  ASSERT_TRUE(X_MO) << X_MO.error().text();
  ASSERT_TRUE(X_OB);
  const RigidTransform X_MB = X_MO->X_TS * X_OB->X_TS;
  EXPECT_NEAR((X_MB.translation_m - truth_.translation_m).norm(), 0.0, 0.02);
  const auto in_map = context_.published<nav_msgs::msg::Odometry>("/global/odometry/filtered").back();
  EXPECT_EQ(in_map.header.frame_id, "map");
  EXPECT_EQ(in_map.child_frame_id, "base_footprint");
  // The odometry's pose of this tick came after the map filter's: it was taken from the one before, 10 mm behind.
  EXPECT_NEAR(in_map.pose.pose.position.x, X_MB.translation_m.x(), 5e-4);
  EXPECT_NEAR(in_map.pose.pose.position.y, X_MB.translation_m.y(), 5e-4);
}

TEST_F(TwoFilters, map_to_odom_stands_while_the_robot_drives) {
  start_both();
  for (int i = 0; i < 50; ++i) drive(0.0, 0.0);
  const RigidTransform first = buffer_->lookup_latest("map", "odom")->X_TS;
  double most_m = 0.0, most_of_the_newest_m = 0.0;
  RigidTransform X_OB_before;
  for (int i = 0; i < 120; ++i) {
    X_OB_before = buffer_->lookup_latest("odom", "base_footprint")->X_TS;
    drive(std::min({1.0, 0.02 * i, 0.02 * (120 - i)}), 0.0);
    const RigidTransform now = buffer_->lookup_latest("map", "odom")->X_TS;
    most_m = std::max(most_m, (now.translation_m - first.translation_m).norm());
    const auto in_map = context_.published<nav_msgs::msg::Odometry>("/global/odometry/filtered").back().pose.pose;
    const RigidTransform X_MB{{in_map.orientation.w, in_map.orientation.x, in_map.orientation.y, in_map.orientation.z},
                              {in_map.position.x, in_map.position.y, in_map.position.z}};
    const RigidTransform newest = X_MB * X_OB_before.inverse();
    most_of_the_newest_m = std::max(most_of_the_newest_m, (newest.translation_m - first.translation_m).norm());
  }
  EXPECT_LT(most_m, 8e-3);
  EXPECT_GT(most_of_the_newest_m, 15e-3) << "what was heard when the map filter had its estimate is a step behind";
}

TEST_F(TwoFilters, without_odom_to_base_the_map_filter_reports_once_and_broadcasts_when_it_is_there) {
  map_ = std::make_unique<EkfComponent>(map_options_);
  ASSERT_TRUE(map_->trigger(Transition::Configure).success);
  ASSERT_TRUE(map_->trigger(Transition::Activate).success);
  const test::LogLines lines;
  for (int i = 0; i < 5; ++i) drive(0.5, 0.0);
  EXPECT_TRUE(context_.published<tf2_msgs::msg::TFMessage>("/tf").empty());
  EXPECT_EQ(context_.published<nav_msgs::msg::Odometry>("/global/odometry/filtered").size(), 5U);
  const auto told = [&](const char* text) {
    return std::count_if(lines.all.begin(), lines.all.end(),
                         [&](const std::string& line) { return line.find(text) != std::string::npos; });
  };
  EXPECT_EQ(told("map -> odom is not broadcast: "), 1) << ::testing::PrintToString(lines.all);
  ASSERT_TRUE(buffer_->insert("odom", "base_footprint", context_.clock().wall_now(), {}, spatial::Permanence::Dynamic));
  drive(0.5, 0.0);
  EXPECT_EQ(context_.published<tf2_msgs::msg::TFMessage>("/tf").size(), 1U);
  EXPECT_EQ(told("map -> odom is broadcast again"), 1) << ::testing::PrintToString(lines.all);
}

TEST_F(TwoFilters, transform_time_offset_is_added_to_the_stamp_of_map_to_odom) {
  map_options_.append_parameter_override("transform_time_offset", 0.1);
  start_both();
  for (int i = 0; i < 10; ++i) drive(0.5, 0.0);
  const auto out = context_.published<nav_msgs::msg::Odometry>("/global/odometry/filtered").back();
  for (const auto& message : context_.published<tf2_msgs::msg::TFMessage>("/tf")) {
    const auto& t = message.transforms.at(0);
    if (t.header.frame_id == "map" && time_of(t.header.stamp) == time_of(out.header.stamp) + 100ms) return;
  }
  ADD_FAILURE() << "no map -> odom has the stamp of the estimate and 0.1 s";
}

}  // namespace
}  // namespace nacelle::ekf
