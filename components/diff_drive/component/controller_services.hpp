// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <controller_manager_msgs/msg/hardware_interface.hpp>
#include <controller_manager_msgs/srv/list_controllers.hpp>
#include <controller_manager_msgs/srv/list_hardware_components.hpp>
#include <controller_manager_msgs/srv/list_hardware_interfaces.hpp>
#include <controller_manager_msgs/srv/set_hardware_component_state.hpp>
#include <controller_manager_msgs/srv/switch_controller.hpp>
#include <memory>
#include <string>
#include <vector>

#include "diff_drive/component/drive_loop.hpp"
#include "diff_drive/model/controllers.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::diff_drive {

/// The node `controller_manager` beside a base: answers ros2_control's services for the two controllers that the base contains.
///
/// While diff_drive_controller is not active, CommandInbox::inactive is set: the wheels stop, and stay so until it is active and
/// the rule of `rearm` is fulfilled. While joint_state_broadcaster is not, CommandInbox::without_joint_states is set.
/// Source:  services and their answers: ros2_control's controller_manager (jazzy 9ffbf97), node `controller_manager`.
/// Threads: made and destroyed with the base; the services run in the callbacks of a node of their own, which may run while the base
///          changes its state. describe() and follow() from any thread.
class ControllerServices final {
 public:
  /// The configured base.
  struct Description {
    std::vector<std::string> left_joints, right_joints;
    double update_rate_hz = 0.0;
    std::string hardware;
  };

  /// `base` and `inbox` outlive this. `options` are the base's.
  ControllerServices(const NodeOptions& options, const LifecycleNode& base, CommandInbox& inbox,
                     Description description);

  void describe(Description description);
  /// The loop that runs from now on; null: none does. A switch waits for its next cycle.
  void follow(DriveLoop* loop);

 private:
  using Interfaces = std::vector<controller_manager_msgs::msg::HardwareInterface>;

  template <typename S, typename Answer>
  void offer(const char* name, Answer answer);
  /// A service that has a name of a controller, and says only whether it did what it was asked for.
  template <typename S, typename Change>
  void offer_change(const char* name, Change change);
  void offer_lists();
  void offer_changes();

  /// Unconfigured, Inactive or Active.
  [[nodiscard]] ControllerState base_state() const;
  void list_controllers(controller_manager_msgs::srv::ListControllers::Response& response) const
      NACELLE_REQUIRES(mutex_);
  void list_hardware(controller_manager_msgs::srv::ListHardwareComponents::Response& response) const
      NACELLE_REQUIRES(mutex_);
  [[nodiscard]] Interfaces command_interfaces() const NACELLE_REQUIRES(mutex_);
  [[nodiscard]] Interfaces state_interfaces() const NACELLE_REQUIRES(mutex_);
  /// "JOINT/velocity" of every wheel: the left ones first.
  [[nodiscard]] std::vector<std::string> of_every_joint(const char* interface) const NACELLE_REQUIRES(mutex_);
  /// Whether the board is there.
  [[nodiscard]] bool is_available() const NACELLE_REQUIRES(mutex_);

  void switch_controllers(const controller_manager_msgs::srv::SwitchController::Request& request,
                          controller_manager_msgs::srv::SwitchController::Response& response);
  [[nodiscard]] Result<SwitchPlan, std::string> plan(
      const controller_manager_msgs::srv::SwitchController::Request& request);
  /// Sets the own state of those, and tells the loop.
  void set_all(const ControllerSet& which, ControllerState own);
  /// The same, and waits until the loop has done a whole cycle with it, or no loop runs. Returns false at the deadline.
  [[nodiscard]] bool apply(const ControllerSet& which, ControllerState own, MonotonicTime deadline);
  /// Tells the loop which controllers run.
  void tell_loop() NACELLE_REQUIRES(mutex_);
  [[nodiscard]] Duration time_limit(const builtin_interfaces::msg::Duration& asked);
  void set_hardware_state(const controller_manager_msgs::srv::SetHardwareComponentState::Request& request,
                          controller_manager_msgs::srv::SetHardwareComponentState::Response& response);

  const LifecycleNode& base_;
  CommandInbox& inbox_;
  mutable Mutex mutex_;
  Controllers controllers_ NACELLE_GUARDED_BY(mutex_);
  Description description_ NACELLE_GUARDED_BY(mutex_);
  DriveLoop* loop_ NACELLE_GUARDED_BY(mutex_) = nullptr;
  // Last, so that no callback finds a part of the above gone.
  Node node_;
  std::vector<std::shared_ptr<void>> services_;
};

}  // namespace nacelle::diff_drive
