// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <sensor_msgs/msg/joy.hpp>
#include <string>

#include "joy/model/twist_map.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::joy {

/// Turns `joy` into velocities on `cmd_vel` (node name "teleop_twist_joy_node"), as ROS 2's teleop_twist_joy: while the enable or turbo
/// button is held, one Twist (or TwistStamped) for each Joy; when it is let go, one zero, and then nothing.
///
/// Parameters may be changed while it runs; they count from the next message on. Deactivation publishes a zero if the last one was none.
/// It does not watch for Joy that stops coming: the base stops without commands (cmd_vel_timeout), and joy_node says when its pad is gone.
class TeleopTwistJoyComponent final : public LifecycleNode, private GateListener {
 public:
  explicit TeleopTwistJoyComponent(const NodeOptions& options);
  ~TeleopTwistJoyComponent() override { remove_gate_listener(*this); }

 private:
  /// What is published in on_deactivate() does not leave any more.
  void before_gate_closes() noexcept override;

  void on_joy(const sensor_msgs::msg::Joy& joy);
  void publish(const PadTwist& twist);
  [[nodiscard]] TwistMap::Settings read_settings() const;

  std::string frame_;
  TwistMap map_;
  bool settings_changed_ = false;
  bool is_stopped_ = false;  // the last message was a zero that says that no button is held
  OnSetParametersCallbackHandle::SharedPtr on_set_;
  // One of them.
  std::shared_ptr<Publisher<geometry_msgs::msg::Twist>> twist_;
  std::shared_ptr<Publisher<geometry_msgs::msg::TwistStamped>> stamped_;
  std::shared_ptr<Subscription<sensor_msgs::msg::Joy>> joy_;
};

}  // namespace nacelle::joy
