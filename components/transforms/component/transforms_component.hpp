// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <sensor_msgs/msg/joint_state.hpp>
#include <std_msgs/msg/string.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/spatial/transform_buffer.hpp"
#include "transforms/component/transforms_options.hpp"

namespace nacelle::transforms {

/// The robot's frames: robot_description and /tf_static when it is activated, /tf as joint states come, and the container's
/// one TransformBuffer, which it fills from all publishers of /tf and /tf_static.
/// Threads: the component's executor. Allocates: nothing at the rate of joint_states and /tf.
class TransformsComponent final : public LifecycleNode {
 public:
  explicit TransformsComponent(const NodeOptions& options);

  [[nodiscard]] JointTransformsStats stats() const { return joints_ ? joints_->stats() : JointTransformsStats{}; }
  [[nodiscard]] const spatial::TransformBufferPtr& buffer() const { return buffer_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  void claim_frames();
  void publish_fixed();
  void on_joint_state(const sensor_msgs::msg::JointState& state);
  /// `writer`: the message's, 0 for an own one.
  void on_transforms(const tf2_msgs::msg::TFMessage& message, spatial::Permanence permanence, std::uint64_t writer);
  void tell_trouble();

  std::optional<TransformsOptions> options_;
  std::optional<JointTransforms> joints_;
  spatial::TransformBufferPtr buffer_;
  std::shared_ptr<const ClockSkews> skews_;
  std::shared_ptr<Publisher<std_msgs::msg::String>> description_;
  std::shared_ptr<Publisher<tf2_msgs::msg::TFMessage>> moving_, fixed_;
  std::shared_ptr<Subscription<sensor_msgs::msg::JointState>> joint_states_;
  std::shared_ptr<Subscription<tf2_msgs::msg::TFMessage>> heard_moving_, heard_fixed_;
  std::vector<std::unique_ptr<FrameClaim>> claims_;
  std::optional<Duration> clock_offset_;  // wall less monotonic
  std::uint64_t told_mismatched_{0}, told_unknown_{0}, refused_{0};
};

}  // namespace nacelle::transforms
