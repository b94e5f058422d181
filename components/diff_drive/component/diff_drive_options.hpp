// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "diff_drive/component/drive_loop.hpp"
#include "diff_drive/component/pwm_options.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle::diff_drive {

/// Limits of an axis as the parameters give them, deprecated names included.
struct AxisOptions {
  AxisLimits limits;
  double min_acceleration = AxisLimits::kOff;  ///< Deprecated: stands in for the three limits that replaced it.
  bool has_velocity_limits = true;             ///< Deprecated: false switches the limit off.
  bool has_acceleration_limits = true;
  bool has_jerk_limits = true;
};

/// A topic of commands, as twist_mux's `topics.NAME`.
struct InputOptions {
  std::string name;   ///< NAME; empty for the one input that there is when none are named.
  std::string topic;  ///< Takes Twist and TwistStamped.
  double timeout_s = 0.5;
  std::int64_t priority = 0;
  /// The parameter that sets timeout_s.
  [[nodiscard]] std::string timeout_parameter() const {
    return name.empty() ? "cmd_vel_timeout" : "topics." + name + ".timeout";
  }
};
/// A topic that locks inputs of a lower priority, as twist_mux's `locks.NAME`.
struct LockOptions {
  std::string name;
  std::string topic;  ///< std_msgs/Bool; true locks.
  double timeout_s = 0.0;
  std::int64_t priority = 0;
};

/// The parameters of the base: diff_drive_controller's names and defaults, and the board's line.
struct DiffDriveOptions {
  std::vector<std::string> left_wheel_names{"left_wheel_joint"};
  std::vector<std::string> right_wheel_names{"right_wheel_joint"};
  double wheel_separation_m = 0.30;
  double wheel_radius_m = 0.033;
  double wheel_separation_multiplier = 1.0;
  double left_wheel_radius_multiplier = 1.0;
  double right_wheel_radius_multiplier = 1.0;
  double cmd_vel_timeout_s = 0.5;                             ///< 0: commands stay in force.
  std::vector<InputOptions> inputs{{"", "cmd_vel", 0.5, 0}};  ///< Never empty; more where `topics` name them.
  std::vector<LockOptions> locks;
  bool emergency_stop_required = false;   ///< Nothing moves while no publisher of the emergency stop shows life.
  double emergency_stop_timeout_s = 0.5;  ///< For so long it may show none.
  std::string rearm = "neutral";          ///< "neutral" or "fresh": see RearmRule.
  bool publish_limited_velocity = false;
  bool use_stamped_vel = true;  ///< The type that the network sees of an input without a publisher; both are taken.
  double update_rate_hz = 50.0;
  double publish_rate_hz = 50.0;  ///< Of joint states, at most; 0: every state of the board.
  double battery_rate_hz = 1.0;
  AxisOptions linear;
  AxisOptions angular;

  std::string hardware = "waveshare";  ///< One of hardware_names().
  std::string serial_port = "/dev/ttyAMA0";
  std::string can_interface = "can0";  ///< Of boards on a CAN bus, instead of serial_port.
  PwmOptions pwm;                      ///< Of `hardware: pwm`.
  std::int64_t baud_rate = 0;          ///< 0: the board's usual one.
  std::int64_t board_address = 0;
  std::int64_t left_channel = -1, right_channel = -1;  ///< In the board's numbers; -1: its usual ones.
  bool left_reversed = false, right_reversed = false;
  double counts_per_turn = 0.0;  ///< Of the wheel, in the board's unit; 0: its usual one.
  double max_wheel_rate_rps = 200.0;
  DeviceOptions device{};
  /// With required_device, configure waits so long for the line; with device_lost: fault, the board may be silent so long. 0: no
  /// wait; no limit.
  double port_timeout_s = 1.0;
  double reopen_timeout_s =
      60.0;  ///< With device_lost: fault, how long a lost line is waited for; 0: it is a fault at once.
  double motor_watchdog_s = 0.5;  ///< The board stops by itself after this silence of ours.
};

/// What checked options mean: the values that the loop and the ports work with.
struct DriveSetup {
  DriveLoop::Settings loop;
  Duration publish_period{};
  Duration battery_period{};
  std::vector<std::string> warnings;  ///< Deprecated names in use, and limits of the board.
};

/// Declares every parameter on the node, also those of the inputs and locks that its overrides name; with these defaults.
/// Errors: rclcpp's named exceptions.
void declare_options(Node& node, const DiffDriveOptions& defaults = {});
/// Returns the option of a parameter that a robot description may set, or null; the names are those of all three kinds.
[[nodiscard]] double* number_named(DiffDriveOptions& options, std::string_view parameter);
[[nodiscard]] std::int64_t* integer_named(DiffDriveOptions& options, std::string_view parameter);
[[nodiscard]] bool* switch_named(DiffDriveOptions& options, std::string_view parameter);
[[nodiscard]] std::vector<std::string> names_of_numbers();
/// Reads the values in force.
[[nodiscard]] DiffDriveOptions read_options(const Node& node);
/// Checks all of them; `node` is the node that has them.
/// Errors: the first Problem, naming parameter, value, what is allowed and the way out.
[[nodiscard]] Result<DriveSetup, Problem> validated(const DiffDriveOptions& options, const std::string& node);

}  // namespace nacelle::diff_drive
