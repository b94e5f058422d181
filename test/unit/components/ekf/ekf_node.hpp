// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "ekf/component/ekf_component.hpp"
#include "ekf_cases.hpp"
#include "support/recording_host.hpp"

namespace nacelle::ekf {

/// An EKF of 50 Hz in two dimensions, with an IMU on the base, and what sends to it.
class EkfNode : public ::testing::Test {
 public:
  EkfNode() {
    options_.append_parameter_override("frequency", 50.0);
    options_.append_parameter_override("two_d_mode", true);
    options_.append_parameter_override("base_link_frame", std::string{"base_footprint"});
    buffer_ = std::static_pointer_cast<spatial::TransformBuffer>(
        context_.shared_object(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer));
    mount_imu();
  }
  void mount_imu() {
    EXPECT_TRUE(buffer_->insert("base_footprint", "imu_link", WallTime{},
                                {Eigen::Quaterniond::Identity(), {0, 0, 0.07}}, spatial::Permanence::Static));
  }
  void start() {
    node_ = std::make_unique<EkfComponent>(options_);
    const auto configured = node_->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(node_->trigger(Transition::Activate).success);
  }
  [[nodiscard]] builtin_interfaces::msg::Time stamp(Duration ago = 0ns) { return context_.clock().wall_now() - ago; }
  void send_odometry(double vx, double vyaw = 0.0, Duration ago = 0ns) {
    context_.inject("/odom", odometry(vx, vyaw, ago));
  }
  [[nodiscard]] nav_msgs::msg::Odometry odometry(double vx, double vyaw = 0.0, Duration ago = 0ns) {
    nav_msgs::msg::Odometry m;
    m.header.stamp = stamp(ago);
    m.header.frame_id = "odom";
    m.child_frame_id = "base_footprint";
    m.twist.twist.linear.x = vx;
    m.twist.twist.angular.z = vyaw;
    for (std::size_t i = 0; i < 6; ++i) m.twist.covariance[i * 7] = 1e-4;
    return m;
  }
  void send_imu(double vyaw, const char* frame = "imu_link") {
    sensor_msgs::msg::Imu m;
    m.header.stamp = stamp();
    m.header.frame_id = frame;
    m.orientation_covariance[0] = -1.0;
    m.angular_velocity.z = vyaw;
    for (std::size_t i = 0; i < 9; i += 4)
      m.angular_velocity_covariance[i] = m.linear_acceleration_covariance[i] = 3e-6;
    m.linear_acceleration.z = 9.81;
    context_.inject("/imu/data_raw", m);
  }
  /// 20 ms as on the robot: two IMU messages, one odometry message, one tick.
  void run(double vx, double vyaw) {
    context_.advance(9ms);
    send_imu(vyaw);
    context_.advance(9ms);
    send_imu(vyaw);
    send_odometry(vx, vyaw);
    context_.advance(2ms);
  }
  std::vector<nav_msgs::msg::Odometry> filtered() {
    return context_.published<nav_msgs::msg::Odometry>("/odometry/filtered");
  }

  test::RecordingContext context_;
  NodeOptions options_{context_};
  spatial::TransformBufferPtr buffer_;
  std::unique_ptr<EkfComponent> node_;
};

}  // namespace nacelle::ekf
