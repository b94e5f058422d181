// SPDX-License-Identifier: Apache-2.0
#include "simulation/model/motor_board.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nacelle::simulation {
namespace {

constexpr double kFastestMps = 2.0;  // source: setGoalSpeed() in movtion_module.h ignores more

std::chrono::milliseconds milliseconds_of(const UgvCommand& command) {
  return std::chrono::milliseconds{static_cast<std::int64_t>(std::clamp(command.cmd.value_or(0.0), -1e7, 1e7))};
}

}  // namespace

void MotorBoard::aim(double left_mps, double right_mps, Duration now) {
  last_motion_ = now;
  watchdog_stopped_ = false;
  if (emergency_stopped_ || std::abs(left_mps) > kFastestMps || std::abs(right_mps) > kFastestMps) return;
  ++motion_commands_;
  left_mps_ = left_mps;
  right_mps_ = right_mps;
}

bool MotorBoard::on_command(const UgvCommand& command, Duration now) {
  switch (command.type) {
    case 0:
      emergency_stopped_ = true;
      left_mps_ = right_mps_ = 0.0;
      break;
    case 999: emergency_stopped_ = false; break;
    case 1:
      // Without both numbers the firmware does nothing at all.
      if (command.left && command.right) aim(*command.left, *command.right, now);
      break;
    case 13: {
      const double turn_mps = command.z.value_or(0.0) * nominal_.track_m / 2.0;
      aim(command.x.value_or(0.0) - turn_mps, command.x.value_or(0.0) + turn_mps, now);
      break;
    }
    case 130: return true;
    case 131: feedback_flows_ = command.cmd.value_or(0.0) != 0.0; break;
    case 136: heartbeat_ = milliseconds_of(command); break;
    case 142: extra_delay_ = std::chrono::abs(milliseconds_of(command)); break;
    case 143: echoes_ = command.cmd.value_or(0.0) != 0.0; break;
    default: break;  // OLED, lights, arm, WiFi: nothing of them is in this world
  }
  return false;
}

std::int64_t MotorBoard::counts(double angle_rad) const {
  return static_cast<std::int64_t>(std::floor(angle_rad / (2.0 * std::numbers::pi) * nominal_.counts_per_turn));
}

void MotorBoard::step(Duration now, double left_angle_rad, double right_angle_rad) {
  if (now - last_motion_ > heartbeat_ && !watchdog_stopped_) {
    watchdog_stopped_ = true;
    if (left_mps_ != 0.0 || right_mps_ != 0.0) ++watchdog_stops_;
    left_mps_ = right_mps_ = 0.0;
  }
  left_counts_ = counts(left_angle_rad);
  right_counts_ = counts(right_angle_rad);
  if (now - measured_at_ >= kLoop) {
    const double m_per_count = 2.0 * std::numbers::pi * nominal_.wheel_radius_m / nominal_.counts_per_turn;
    const double dt_s = to_seconds(now - measured_at_);
    left_measured_mps_ = static_cast<double>(left_counts_ - left_counts_before_) * m_per_count / dt_s;
    right_measured_mps_ = static_cast<double>(right_counts_ - right_counts_before_) * m_per_count / dt_s;
    left_counts_before_ = left_counts_;
    right_counts_before_ = right_counts_;
    measured_at_ = now;
  }
}

void MotorBoard::describe(UgvFeedback& feedback) const {
  const double m_per_count = 2.0 * std::numbers::pi * nominal_.wheel_radius_m / nominal_.counts_per_turn;
  feedback.left_mps = left_measured_mps_;
  feedback.right_mps = right_measured_mps_;
  feedback.odometry_left_m = static_cast<double>(left_counts_) * m_per_count;
  feedback.odometry_right_m = static_cast<double>(right_counts_) * m_per_count;
  // A three-cell battery that sags a little under load.
  feedback.volts = 12.1 - 0.2 * (std::abs(left_mps_) + std::abs(right_mps_));
}

}  // namespace nacelle::simulation
