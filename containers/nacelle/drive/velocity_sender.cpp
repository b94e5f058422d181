// SPDX-License-Identifier: Apache-2.0
#include "drive/velocity_sender.hpp"

#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>

#include "nacelle/msgs/message_type.hpp"

namespace nacelle::drive {

Result<VelocitySender, Problem> VelocitySender::open(control::Client& client, const std::string& topic, bool stamped,
                                                     std::string frame) {
  auto handle = client.open_writer(topic, stamped ? "geometry_msgs/msg/TwistStamped" : "geometry_msgs/msg/Twist", 2s);
  if (!handle) return err(handle.error());
  return VelocitySender{client, handle.value(), stamped, std::move(frame)};
}

Result<void, Problem> VelocitySender::send(double speed_mps, double yaw_rate_rps, WallTime stamp) {
  geometry_msgs::msg::Twist twist;
  twist.linear.x = speed_mps;
  twist.angular.z = yaw_rate_rps;
  if (!stamped_) return client_->publish(handle_, msgs::to_cdr(twist));
  geometry_msgs::msg::TwistStamped message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_;
  message.twist = twist;
  return client_->publish(handle_, msgs::to_cdr(message));
}

}  // namespace nacelle::drive
