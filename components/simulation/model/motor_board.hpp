// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"
#include "simulation/model/world_settings.hpp"
#include "simulation/protocol/ugv_device.hpp"

namespace nacelle::simulation {

/// The firmware of a Waveshare UGV board: set points, its own watchdog, emergency stop, encoders, feedback.
///
/// It believes in the nominal radius and track: that is where wheel odometry's error comes from. Times are world times.
class MotorBoard {
 public:
  explicit MotorBoard(const RobotNominal& nominal) : nominal_(nominal) {}

  /// Carries a command out; true if it asks for one feedback line now (T 130).
  bool on_command(const UgvCommand& command, Duration now);
  /// Looks at the watchdog and the encoders. Call it at every step of the world.
  void step(Duration now, double left_angle_rad, double right_angle_rad);

  /// What the motors aim at. Units: rad/s of the wheels.
  [[nodiscard]] double left_target_rps() const { return left_mps_ / nominal_.wheel_radius_m; }
  [[nodiscard]] double right_target_rps() const { return right_mps_ / nominal_.wheel_radius_m; }
  [[nodiscard]] double left_command_mps() const { return left_mps_; }
  [[nodiscard]] double right_command_mps() const { return right_mps_; }

  /// Fills in wheel speeds, odometry and voltage as the board knows them.
  void describe(UgvFeedback& feedback) const;
  [[nodiscard]] bool feedback_flows() const { return feedback_flows_; }
  /// Least time between two feedback lines: the firmware's loop and what T 142 adds.
  [[nodiscard]] Duration feedback_interval() const { return kLoop + extra_delay_; }
  [[nodiscard]] bool echoes() const { return echoes_; }
  [[nodiscard]] bool stopped_by_watchdog() const { return watchdog_stopped_; }
  /// How often it stopped wheels that were to turn.
  [[nodiscard]] std::uint64_t watchdog_stops() const { return watchdog_stops_; }
  /// Motion commands that were carried out.
  [[nodiscard]] std::uint64_t motion_commands() const { return motion_commands_; }

  /// The firmware's loop; speed is measured over one. Source: the loop of ROS_Driver.ino reads the IMU over I2C and the
  /// encoders each time round; 10 ms is what that takes.
  static constexpr Duration kLoop = 10ms;

 private:
  void aim(double left_mps, double right_mps, Duration now);
  [[nodiscard]] std::int64_t counts(double angle_rad) const;

  const RobotNominal nominal_;
  double left_mps_ = 0.0, right_mps_ = 0.0;
  bool emergency_stopped_ = false, watchdog_stopped_ = false, feedback_flows_ = true, echoes_ = false;
  Duration heartbeat_ = 3000ms;  // source: HEART_BEAT_DELAY in ugv_config.h
  Duration extra_delay_{};
  Duration last_motion_{};
  std::uint64_t motion_commands_ = 0, watchdog_stops_ = 0;
  std::int64_t left_counts_ = 0, right_counts_ = 0;
  std::int64_t left_counts_before_ = 0, right_counts_before_ = 0;
  double left_measured_mps_ = 0.0, right_measured_mps_ = 0.0;
  Duration measured_at_{};
};

}  // namespace nacelle::simulation
