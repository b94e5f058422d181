// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/drive_topics.hpp"

#include <limits>
#include <utility>

namespace nacelle::diff_drive {

DriveTopics::DriveTopics(Publishers publishers, Settings settings, const Clock& clock,
                         DurationHistogram& command_to_wheel)
    : publishers_(std::move(publishers)),
      settings_(std::move(settings)),
      clock_(clock),
      command_to_wheel_(command_to_wheel),
      joint_gate_(settings_.publish_period),
      battery_gate_(settings_.battery_period) {}

WallTime DriveTopics::wall_time_of(MonotonicTime instant) const { return clock_.wall_now() - (clock_.now() - instant); }

void DriveTopics::on_wheel_state(const WheelState& state) {
  const bool is_quiet = without_joint_states_ != nullptr && without_joint_states_->load(std::memory_order_acquire);
  if (!is_quiet && joint_gate_.passes(state.captured_at)) publish_joints(state);
  if (state.voltage_v && battery_gate_.passes(state.captured_at)) publish_battery(state);
}

void DriveTopics::publish_joints(const WheelState& state) {
  auto message = publishers_.joint_states->borrow();
  if (!message) return;  // counted by the writer
  message->header.stamp = wall_time_of(state.captured_at);
  message->header.frame_id.clear();
  const std::size_t left = settings_.left_joints.size();
  const std::size_t all = left + settings_.right_joints.size();
  message->name.resize(all);
  message->position.resize_uninitialized(all);
  message->velocity.resize_uninitialized(all);
  message->effort.clear();
  for (std::size_t i = 0; i < all; ++i) {
    const bool is_left = i < left;
    // Assigning a text of the same length to a pooled message writes into the text that is there.
    message->name[i] = is_left ? settings_.left_joints[i] : settings_.right_joints[i - left];
    message->position[i] = is_left ? state.left_rad : state.right_rad;
    message->velocity[i] = is_left ? state.rates.left_rps : state.rates.right_rps;
  }
  publishers_.joint_states->publish(std::move(message));
}

void DriveTopics::publish_battery(const WheelState& state) {
  using sensor_msgs::msg::BatteryState;
  auto message = publishers_.battery->borrow();
  if (!message) return;
  constexpr float kUnmeasured = std::numeric_limits<float>::quiet_NaN();
  message->header.stamp = wall_time_of(state.captured_at);
  message->header.frame_id.clear();
  message->voltage = static_cast<float>(*state.voltage_v);
  message->temperature = kUnmeasured;
  message->current = kUnmeasured;
  message->charge = kUnmeasured;
  message->capacity = kUnmeasured;
  message->design_capacity = kUnmeasured;
  message->percentage = kUnmeasured;
  message->power_supply_status = BatteryState::POWER_SUPPLY_STATUS_UNKNOWN;
  message->power_supply_health = BatteryState::POWER_SUPPLY_HEALTH_UNKNOWN;
  message->power_supply_technology = BatteryState::POWER_SUPPLY_TECHNOLOGY_UNKNOWN;
  message->present = true;
  message->cell_voltage.clear();
  message->cell_temperature.clear();
  message->location.clear();
  message->serial_number.clear();
  publishers_.battery->publish(std::move(message));
}

void DriveTopics::on_cycle(const BodyTwist& commanded, MonotonicTime now) {
  if (!publishers_.limited_velocity) return;
  auto message = publishers_.limited_velocity->borrow();
  if (!message) return;
  message->header.stamp = wall_time_of(now);
  message->header.frame_id = "base_link";
  message->twist = {};
  message->twist.linear.x = commanded.linear_mps;
  message->twist.angular.z = commanded.angular_rps;
  publishers_.limited_velocity->publish(std::move(message));
}

}  // namespace nacelle::diff_drive
