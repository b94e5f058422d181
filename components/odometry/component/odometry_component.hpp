// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include <nav_msgs/msg/odometry.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <std_srvs/srv/empty.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include "nacelle/node/base_wheels.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "odometry/component/odometry_options.hpp"
#include "odometry/model/joint_reader.hpp"
#include "odometry/model/velocity_window.hpp"

namespace nacelle::odometry {

/// Wheel odometry: joint_states (positions, of encoders that may count in a circle; else speeds) in, odom (one per sample, with its stamp) and
/// the transform odom -> base out.
///
/// Wheels, separation and radius that are not parameters of it are those of the base in its namespace.
/// It owns the transform only while no stronger claim exists (an EKF); it logs the owner once. The service reset_odom
/// (std_srvs/Empty, as ROS users call it) puts the pose back to the origin.
/// Threads: the component's executor. Allocates: nothing at the rate of joint_states.
class OdometryComponent final : public LifecycleNode {
 public:
  explicit OdometryComponent(const NodeOptions& options);

  [[nodiscard]] JointReaderStats stats() const { return reader_ ? reader_->stats() : JointReaderStats{}; }
  [[nodiscard]] const PlanarPose& pose() const { return pose_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  /// The base that has these wheels; the only one, if this node's parameters name no wheels.
  [[nodiscard]] std::optional<BaseWheels> find_base() const;
  /// The base's wheels, as far as this node was not given its own.
  void take_wheels_of_base();
  [[nodiscard]] bool is_given(const char* parameter) const;
  void on_joint_state(const sensor_msgs::msg::JointState& joints);
  void reset_pose();
  void publish_odometry(const sensor_msgs::msg::JointState& joints, const WheelStep& step, double dt_s);
  void publish_transform(const sensor_msgs::msg::JointState& joints);
  void tell_jumps();
  void tell_incomplete(const sensor_msgs::msg::JointState& joints);

  OdometryOptions options_;
  const std::shared_ptr<BaseWheelsList> wheels_;
  std::optional<JointReader> reader_;
  std::optional<VelocityWindow> velocity_;
  PlanarPose pose_;
  std::shared_ptr<Publisher<nav_msgs::msg::Odometry>> odometry_;
  std::shared_ptr<Publisher<tf2_msgs::msg::TFMessage>> transforms_;
  std::shared_ptr<Subscription<sensor_msgs::msg::JointState>> joints_;
  std::shared_ptr<Service<std_srvs::srv::Empty>> reset_;
  std::unique_ptr<FrameClaim> claim_;
  bool told_owner_{false};
  std::uint64_t told_jumps_{0};
  bool told_incomplete_{false};
};

}  // namespace nacelle::odometry
