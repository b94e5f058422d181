// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <std_msgs/msg/bool.hpp>
#include <std_srvs/srv/set_bool.hpp>
#include <string>
#include <thread>

#include "estop/port/gpio_line.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/node/device_watch.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::estop {

/// Sets and releases the emergency stop: a service, and a button on a GPIO line.
///
/// It publishes on the latched topic `emergency_stop`, as other programs may (`nacelle estop`, a remote node); the base
/// obeys the topic. A pressed button sets the stop, and sets it again after any release; letting the button go does not
/// release it. A button that cannot be read, or is absent, counts as pressed and is an open fault (DEVICE_LOST) until
/// it is back; the robot moves again only after a release of the stop. With device_lost: fault it is the fault
/// GPIO_LOST. While it is active, and its executor and its button's thread run, it asserts its liveliness
/// (manual_by_topic, 0.5 s): a base with emergency_stop_required moves only then.
/// Threads: the executor's; the button's thread has a publisher of its own.
class EmergencyStopComponent final : public LifecycleNode {
 public:
  using OpenSwitch = std::function<Result<std::unique_ptr<SwitchPort>, Problem>(const GpioSettings&, const Clock&)>;

  explicit EmergencyStopComponent(const NodeOptions& options) : EmergencyStopComponent(options, open_gpio_switch) {}
  /// With another kind of button.
  EmergencyStopComponent(const NodeOptions& options, OpenSwitch open_switch);
  ~EmergencyStopComponent() override { end_watch(); }

  [[nodiscard]] bool is_pressed() const { return pressed_; }

 protected:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State& state) override { return on_cleanup(state); }
  CallbackReturn on_error(const State& state) override { return on_cleanup(state); }

 private:
  using Bool = std_msgs::msg::Bool;
  using SetBool = std_srvs::srv::SetBool;

  [[nodiscard]] Result<GpioSettings, Problem> gpio_settings() const;
  void on_request(const SetBool::Request& request, SetBool::Response& response);
  void on_heard(const Bool& stop);
  void show_life();
  static PublishResult say(Publisher<Bool>& publisher, bool stop);
  void watch() noexcept;
  /// Reports the fault of the button, pauses, and reopens it. Returns false when the thread has to end.
  [[nodiscard]] bool bring_back(Duration length);
  /// Returns false when the thread is to end.
  [[nodiscard]] bool pause(Duration length);
  void end_watch();

  const OpenSwitch open_switch_;
  std::shared_ptr<Publisher<Bool>> publisher_;         // the executor's
  std::shared_ptr<Publisher<Bool>> button_publisher_;  // the button's thread's, while there is one
  DeviceOptions device_;
  GpioSettings gpio_;
  bool has_button_ = false;
  std::unique_ptr<DeviceWatch> watch_;
  Mutex mutex_;  // button_ while the thread runs
  std::condition_variable end_asked_;
  std::unique_ptr<SwitchPort> button_;  // null: it is absent
  std::thread thread_;
  std::atomic<bool> ended_{false}, pressed_{false};
  std::shared_ptr<Subscription<Bool>> heard_;
  std::atomic<std::int64_t> looked_at_ns_{0};  // at the button, CLOCK_MONOTONIC
  std::shared_ptr<Service<SetBool>> service_;
  std::shared_ptr<Timer> life_;
};

}  // namespace nacelle::estop
