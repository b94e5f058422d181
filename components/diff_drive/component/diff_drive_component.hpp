// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <std_msgs/msg/bool.hpp>
#include <thread>
#include <vector>

#include "diff_drive/component/controller_services.hpp"
#include "diff_drive/component/described_base.hpp"
#include "diff_drive/component/diff_drive_options.hpp"
#include "diff_drive/component/drive_loop.hpp"
#include "diff_drive/component/drive_topics.hpp"
#include "diff_drive/model/emergency_latch.hpp"
#include "nacelle/node/base_wheels.hpp"
#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/node/motion_stops.hpp"

namespace nacelle::diff_drive {

/// The base: takes commands (Twist or TwistStamped), drives two wheels, publishes their states and the battery's.
///
/// Commands arrive on cmd_vel, or on the topics of the parameters `topics`, of which the one with the highest priority commands.
/// `emergency_stop` (std_msgs/Bool; any publisher can set it, and a latched one release it) stops the wheels until it is released.
/// With `emergency_stop_required` the wheels also stop while no publisher of it is alive (liveliness manual_by_topic).
/// While anything keeps the base from following its commands, /diagnostics names it (design D7).
/// With `controller_manager`, a second node has ros2_control's services, which deactivate its two controllers (ControllerServices).
///
/// configure opens the line and registers the stop frame with the container; activate stops the wheels and starts the
/// control loop on its own thread "diff_drive_loop"; deactivate, cleanup, shutdown, errors and the destructor end the
/// loop and write the stop frame. After a stop, an activation included, nothing moves until the rule of `rearm` is fulfilled.
/// Threads: the executor's; the loop gets commands through a CommandInbox and owns the publishers while it runs.
class DiffDriveComponent : public LifecycleNode {
 public:
  /// How many commands were not followed, by cause.
  struct CommandStats {
    std::uint64_t accepted = 0;
    std::array<std::uint64_t, kCommandFaults> refused{};  ///< Indexed by CommandFault.
  };

  explicit DiffDriveComponent(const NodeOptions& options);
  ~DiffDriveComponent() override;

  [[nodiscard]] const CommandStats& command_stats() const { return command_stats_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State&) override;
  CallbackReturn on_error(const State&) override;

 private:
  /// Enters the wheels in the container's list, for odometry.
  void tell_wheels();
  void listen_to(std::size_t source, const std::string& topic);
  void listen_to_lock(std::size_t lock, const std::string& topic);
  void on_twist(std::size_t source, const geometry_msgs::msg::Twist& twist, const MessageInfo& info);
  void on_twist_stamped(std::size_t source, const geometry_msgs::msg::TwistStamped& command, const MessageInfo& info);
  void listen_for_emergency_stop();
  void listen_for_guards();
  void on_emergency_stop(const std_msgs::msg::Bool& stop, const MessageInfo& info);
  void refuse_command(std::size_t source, CommandFault fault, const MessageInfo& info);
  [[nodiscard]] bool is_stale(std::size_t source, const builtin_interfaces::msg::Time& stamp) const;
  /// Says what keeps the base from following its commands, when that changes, and once a second while it lasts.
  void tell_hindrance();

  [[nodiscard]] ControllerServices::Description description() const;
  [[nodiscard]] Result<std::unique_ptr<BasePort>, Problem> open_base() const;
  /// Of boards on CAN.
  [[nodiscard]] Result<std::unique_ptr<BasePort>, Problem> open_bus() const;
  /// Of motors on this computer's own pins.
  [[nodiscard]] Result<std::unique_ptr<BasePort>, Problem> open_pins() const;
  void run_loop() noexcept;
  /// Ends the loop's thread and writes the stop frame; does nothing when neither is there.
  void stop_base();
  void close_base();

  const DescribedBase described_;
  DiffDriveOptions options_;
  DriveSetup setup_;
  DurationHistogram& command_to_wheel_;
  const std::shared_ptr<MotionStops> motion_stops_;
  const std::shared_ptr<BaseWheelsList> wheels_;
  DriveTopics::Publishers publishers_;
  std::shared_ptr<Publisher<geometry_msgs::msg::TwistStamped>> limited_velocity_;
  std::shared_ptr<Publisher<diagnostic_msgs::msg::DiagnosticArray>> diagnostics_;
  CommandInbox inbox_;
  EmergencyLatch emergency_;
  std::string hindrance_;  // as last reported; empty: none
  int ticks_until_told_ = 0;
  CommandStats command_stats_;
  std::array<bool, kCommandFaults> refusal_told_{};

  std::unique_ptr<BasePort> base_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<DriveTopics> topics_;
  std::unique_ptr<DriveLoop> loop_;
  std::thread loop_thread_;

  // Last, so that no callback finds a part of the above gone.
  std::vector<std::shared_ptr<SubscriptionBase>> listeners_;
  std::shared_ptr<Timer> hindrance_timer_;
  std::unique_ptr<ControllerServices> controllers_;  // null without the parameter controller_manager
};

}  // namespace nacelle::diff_drive
