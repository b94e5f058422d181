// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "navsat/component/navsat_transform_component.hpp"
#include "support/recording_host.hpp"

namespace nacelle::navsat {

/// A component of 10 Hz in Darmstadt, and what sends to it.
class NavsatNode : public ::testing::Test {
 public:
  using NavSatFix = sensor_msgs::msg::NavSatFix;
  using Odometry = nav_msgs::msg::Odometry;

  static constexpr double kLatitude = 49.8728, kLongitude = 8.6512, kAltitude = 144.0;

  NavsatNode() {
    buffer_ = std::static_pointer_cast<spatial::TransformBuffer>(
        context_.shared_object(spatial::kTransformBufferName, &spatial::make_shared_transform_buffer));
    mount("gps_link", {Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.0}});
  }
  void mount(const char* frame, const RigidTransform& X_BF) {
    EXPECT_TRUE(buffer_->insert("base_link", frame, WallTime{}, X_BF, spatial::Permanence::Static));
  }
  template <typename T>
  void set(const std::string& parameter, const T& value) {
    options_.append_parameter_override(parameter, value);
  }
  void start() {
    node_ = std::make_unique<NavsatTransformComponent>(options_);
    const auto configured = node_->trigger(Transition::Configure);
    ASSERT_TRUE(configured.success) << configured.reason;
    ASSERT_TRUE(node_->trigger(Transition::Activate).success);
  }
  [[nodiscard]] NavSatFix fix(const GeoPoint& point, const char* frame = "gps_link") {
    NavSatFix m;
    m.header.stamp = context_.clock().wall_now();
    m.header.frame_id = frame;
    m.status.status = sensor_msgs::msg::NavSatStatus::STATUS_FIX;
    m.latitude = point.latitude_deg;
    m.longitude = point.longitude_deg;
    m.altitude = point.altitude_m;
    m.position_covariance = {4.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 9.0};
    m.position_covariance_type = NavSatFix::COVARIANCE_TYPE_DIAGONAL_KNOWN;
    return m;
  }
  void send_fix(const GeoPoint& point = {kLatitude, kLongitude, kAltitude}) { context_.inject("/gps/fix", fix(point)); }
  void send_pose(const RigidTransform& X_WB = {}) {
    Odometry m;
    m.header.stamp = context_.clock().wall_now();
    m.header.frame_id = "map";
    m.child_frame_id = "base_link";
    m.pose.pose.position.x = X_WB.translation_m.x();
    m.pose.pose.position.y = X_WB.translation_m.y();
    m.pose.pose.position.z = X_WB.translation_m.z();
    write(X_WB.rotation, m.pose.pose.orientation);
    m.pose.covariance[0] = 0.25;
    m.pose.covariance[7] = 0.09;
    m.pose.covariance[14] = 1.0;
    context_.inject("/odometry/filtered", m);
  }
  void send_imu(double yaw_rad, const char* frame = "base_link") {
    send_imu(spatial::quaternion_from_yaw(yaw_rad), frame);
  }
  void send_imu(const Eigen::Quaterniond& orientation, const char* frame = "base_link", double yaw_variance = 1e-4) {
    sensor_msgs::msg::Imu m;
    m.header.stamp = context_.clock().wall_now();
    m.header.frame_id = frame;
    write(orientation, m.orientation);
    m.orientation_covariance = {1e-4, 0.0, 0.0, 0.0, 1e-4, 0.0, 0.0, 0.0, yaw_variance};
    context_.inject("/imu", m);
  }
  /// Aligns the frames: the robot is at the world's origin with this heading.
  void align(double heading_rad = 0.0) {
    send_pose();
    send_imu(heading_rad);
    send_fix();
    context_.advance(100ms);
    ASSERT_TRUE(node_->is_aligned());
  }
  [[nodiscard]] std::vector<Odometry> odometry() { return context_.published<Odometry>("/odometry/gps"); }
  [[nodiscard]] std::vector<NavSatFix> filtered() { return context_.published<NavSatFix>("/gps/filtered"); }
  /// The newest position on odometry/gps.
  [[nodiscard]] Eigen::Vector3d last() {
    const auto all = odometry();
    if (all.empty()) return Eigen::Vector3d::Constant(std::nan(""));
    const auto& p = all.back().pose.pose.position;
    return {p.x, p.y, p.z};
  }
  /// A point so far from the datum. Source: radii of curvature of WGS 84 at the datum's latitude.
  [[nodiscard]] static GeoPoint beside(double east_m, double north_m, double up_m = 0.0) {
    constexpr double kA = 6378137.0, kE2 = 0.00669437999014;
    const double sine = std::sin(kLatitude * M_PI / 180.0);
    const double w = std::sqrt(1.0 - kE2 * sine * sine);
    const double across_m = kA / w + kAltitude, along_m = kA * (1.0 - kE2) / (w * w * w) + kAltitude;
    return {kLatitude + north_m / along_m * 180.0 / M_PI,
            kLongitude + east_m / (across_m * std::cos(kLatitude * M_PI / 180.0)) * 180.0 / M_PI, kAltitude + up_m};
  }
  static void write(const Eigen::Quaterniond& from, geometry_msgs::msg::Quaternion& to) {
    to.w = from.w();
    to.x = from.x();
    to.y = from.y();
    to.z = from.z();
  }

  test::RecordingContext context_;
  NodeOptions options_{context_};
  spatial::TransformBufferPtr buffer_;
  std::unique_ptr<NavsatTransformComponent> node_;
};

}  // namespace nacelle::navsat
