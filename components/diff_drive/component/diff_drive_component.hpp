// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <thread>

#include "diff_drive/component/diff_drive_options.hpp"
#include "diff_drive/component/drive_loop.hpp"
#include "diff_drive/component/drive_topics.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::diff_drive {

/// The base: takes cmd_vel (Twist or TwistStamped), drives two wheels, tells their states and the battery.
///
/// configure opens the line and registers the stop frame with the container; activate stops the wheels and starts the
/// control loop on its own thread "diff_drive_loop"; deactivate, cleanup, shutdown, errors and the destructor end the
/// loop and write the stop frame. After an activation nothing moves until a command comes that was sent after it.
/// Threads: the executor's; the loop gets commands through a LatestValue and owns the publishers while it runs.
class DiffDriveComponent final : public LifecycleNode {
 public:
  /// How many commands were not followed, by cause.
  struct CommandStats {
    std::uint64_t accepted = 0;
    std::array<std::uint64_t, 3> refused{};  ///< Indexed by CommandFault.
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
  void on_twist(const geometry_msgs::msg::Twist& twist, const MessageInfo& info);
  void on_twist_stamped(const geometry_msgs::msg::TwistStamped& command, const MessageInfo& info);
  void refuse_command(CommandFault fault);
  [[nodiscard]] bool is_stale(const builtin_interfaces::msg::Time& stamp) const;

  [[nodiscard]] Result<std::unique_ptr<BasePort>, Problem> open_base() const;
  void run_loop() noexcept;
  /// Ends the loop's thread and writes the stop frame; does nothing when neither is there.
  void stop_base();
  void close_base();

  DiffDriveOptions options_;
  DriveSetup setup_;
  DurationHistogram& command_to_wheel_;
  DriveTopics::Publishers publishers_;
  std::shared_ptr<Publisher<geometry_msgs::msg::TwistStamped>> limited_velocity_;
  LatestValue<DriveCommand> commands_;
  CommandStats command_stats_;
  std::array<bool, 3> refusal_told_{};

  std::unique_ptr<BasePort> base_;
  std::unique_ptr<DriveTopics> topics_;
  std::unique_ptr<DriveLoop> loop_;
  std::thread loop_thread_;

  // Last, so that no callback finds a part of the above gone.
  std::shared_ptr<Subscription<geometry_msgs::msg::Twist>> twists_;
  std::shared_ptr<Subscription<geometry_msgs::msg::TwistStamped>> stamped_twists_;
};

}  // namespace nacelle::diff_drive
