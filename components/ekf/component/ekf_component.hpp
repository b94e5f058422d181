// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <diagnostic_msgs/srv/self_test.hpp>
#include <geometry_msgs/msg/accel_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <robot_localization/srv/set_pose.hpp>
#include <robot_localization/srv/toggle_filter_processing.hpp>
#include <std_srvs/srv/empty.hpp>
#include <tf2_msgs/msg/tf_message.hpp>
#include "ekf/component/assist_report.hpp"
#include "ekf/component/debug_output.hpp"
#include "ekf/component/ekf_options.hpp"
#include "ekf/component/input.hpp"
#include "ekf/component/late_report.hpp"
#include "ekf/component/report.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/spatial/transform_buffer.hpp"

namespace nacelle::ekf {

/// robot_localization's ekf_node as a component: the inputs of its parameters in, odometry/filtered and the transform of the
/// estimate out, one each per tick of `frequency`, with stamps that only grow.
///
/// A tick without a new measurement publishes the state carried on to now, where ekf_node stays silent. set_pose is a topic
/// and a service, reset, enable and toggle are services; with use_control cmd_vel is an input of the prediction. The component looks up the frames of
/// its inputs in the container's one TransformBuffer.
/// Threads: the component's executor. Allocates: nothing at the rate of the inputs and outputs.
class EkfComponent final : public LifecycleNode {
 public:
  explicit EkfComponent(const NodeOptions& options);

  /// The counters of "odom0 twist", "imu0 angular_velocity" and so on; null for another name or before it is configured.
  [[nodiscard]] const PartStats* stats(std::string_view part) const;

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;

 private:
  template <typename Message>
  void listen(std::size_t index, const InputOptions& input);
  void tick();
  void publish(const Filter::Output& output);
  void publish_transform(const Filter::Output& output);
  void publish_acceleration(const Filter::Output& output);
  void set_pose(const geometry_msgs::msg::PoseWithCovarianceStamped& message);
  void reset();
  void after_time_reset();
  void enable();
  void answer_status(diagnostic_msgs::srv::SelfTest::Response& response);
  [[nodiscard]] bool toggle(bool on);
  [[nodiscard]] std::optional<Problem> open_debug_output();
  [[nodiscard]] std::optional<RigidTransform> map_to_odom(const Filter::Output& output);
  void listen_to_commands(bool stamped);
  void command(const geometry_msgs::msg::Twist& twist, WallTime stamp);

  std::optional<EkfOptions> options_;
  std::unique_ptr<DebugOutput> debug_;  // outlives the filter
  std::optional<Filter> filter_;
  std::vector<std::unique_ptr<Input>> inputs_;
  std::optional<Watch> watch_;
  std::optional<LateWatch> late_watch_;
  AssistWatch assist_watch_;
  spatial::TransformBufferPtr buffer_;
  std::shared_ptr<const ClockSkews> skews_;
  std::vector<std::shared_ptr<SubscriptionBase>> subscriptions_;
  std::shared_ptr<Subscription<geometry_msgs::msg::PoseWithCovarianceStamped>> set_pose_topic_;
  std::shared_ptr<Service<robot_localization::srv::SetPose>> set_pose_service_;
  std::shared_ptr<Service<std_srvs::srv::Empty>> reset_service_, enable_service_;
  std::shared_ptr<Service<diagnostic_msgs::srv::SelfTest>> status_service_;
  std::shared_ptr<Service<robot_localization::srv::ToggleFilterProcessing>> toggle_service_;
  std::shared_ptr<SubscriptionBase> commands_;
  std::shared_ptr<Publisher<nav_msgs::msg::Odometry>> odometry_;
  std::shared_ptr<Publisher<geometry_msgs::msg::AccelWithCovarianceStamped>> acceleration_;
  std::shared_ptr<Publisher<tf2_msgs::msg::TFMessage>> transforms_;
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  std::shared_ptr<Timer> timer_;
  std::unique_ptr<FrameClaim> claim_;
  MonotonicTime next_look_{};
  std::uint64_t time_resets_{0};  // of the filter, as seen last
  bool enabled_{true};
  bool toggled_on_{true};
  bool told_no_odom_{false};
  bool follows_sim_time_{false};
  bool told_disabled_{false};
  bool told_command_frame_{false};
};

}  // namespace nacelle::ekf
