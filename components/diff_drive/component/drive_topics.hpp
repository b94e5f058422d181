// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <memory>
#include <sensor_msgs/msg/battery_state.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <string>
#include <vector>

#include "diff_drive/component/drive_loop.hpp"
#include "diff_drive/model/rate_gate.hpp"
#include "nacelle/base/histogram.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/publisher.hpp"

namespace nacelle::diff_drive {

/// Publishes the results of the loop: joint states, battery, the limited velocity, latencies.
///
/// Threads:   made on the executor, then the loop's; the publishers are the loop's as long as it runs.
/// Allocates: nothing once each pooled message has been filled for the first time.
class DriveTopics final : public DriveObserver {
 public:
  struct Publishers {
    std::shared_ptr<Publisher<sensor_msgs::msg::JointState>> joint_states;
    std::shared_ptr<Publisher<sensor_msgs::msg::BatteryState>> battery;
    std::shared_ptr<Publisher<geometry_msgs::msg::TwistStamped>> limited_velocity;  ///< Null: not published.
  };
  struct Settings {
    std::vector<std::string> left_joints, right_joints;
    Duration publish_period{};
    Duration battery_period{};
  };
  /// Reports the loss of the board there; null: nowhere.
  void watch_with(DeviceWatch* watch) { watch_ = watch; }
  /// Publishes no joint states while that is true. It outlives this.
  void be_quiet_while(const std::atomic<bool>* without_joint_states) { without_joint_states_ = without_joint_states; }

  DriveTopics(Publishers publishers, Settings settings, const Clock& clock, DurationHistogram& command_to_wheel);

  void on_wheel_state(const WheelState& state) override;
  void on_cycle(const BodyTwist& commanded, MonotonicTime now) override;
  void on_command_written(Duration since_published) override { command_to_wheel_.record(since_published); }
  void on_board_lost(std::string_view why) override {
    if (watch_ != nullptr) watch_->lose(std::string(why));
  }
  void on_board_back(MonotonicTime now) override {
    if (watch_ != nullptr) watch_->heard(now);
  }

 private:
  /// The wall-clock time of a monotonic instant that has just been.
  [[nodiscard]] WallTime wall_time_of(MonotonicTime instant) const;
  void publish_joints(const WheelState& state);
  void publish_battery(const WheelState& state);

  const Publishers publishers_;
  const Settings settings_;
  const Clock& clock_;
  DurationHistogram& command_to_wheel_;
  RateGate joint_gate_;
  RateGate battery_gate_;
  DeviceWatch* watch_ = nullptr;
  const std::atomic<bool>* without_joint_states_ = nullptr;
};

}  // namespace nacelle::diff_drive
