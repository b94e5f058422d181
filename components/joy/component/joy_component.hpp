// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "joy/component/joy_stream.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::joy {

/// A gamepad or joystick, published as sensor_msgs/Joy on `joy` (node name "joy_node"), as ROS 2's joy does: same order, signs, parameters.
///
/// configure opens the gamepad, if it is there; the thread "joy_rx" publishes.
/// Errors: an open fault DEVICE_LOST while the gamepad is absent; with device_lost: fault the fault JOY_ABSENT after silence_limit. A gamepad
/// that disappears is published once with all buttons up and all axes 0, so that what it drives stops; then nothing is published until it
/// is back.
class JoyComponent : public LifecycleNode, private GateListener {
 public:
  /// Opens the gamepad; tests give a scripted one.
  using OpenPad =
      std::function<Result<std::unique_ptr<PadPort>, Problem>(const JoyOptions& options, const Clock& clock)>;

  explicit JoyComponent(const NodeOptions& options);
  JoyComponent(const NodeOptions& options, OpenPad open_pad);
  ~JoyComponent() override;

 private:
  CallbackReturn on_configure(const State&) override;
  CallbackReturn on_activate(const State&) override;
  CallbackReturn on_deactivate(const State&) override;
  CallbackReturn on_cleanup(const State&) override;
  CallbackReturn on_shutdown(const State&) override;
  CallbackReturn on_error(const State&) override;

  /// What is published in on_deactivate() does not leave any more.
  void before_gate_closes() noexcept override;
  void close();
  void log_counters() const;

  OpenPad open_pad_;
  std::shared_ptr<Publisher<sensor_msgs::msg::Joy>> publisher_;
  // In this order: the thread ends before the objects that it uses.
  std::unique_ptr<PadPort> pad_;
  std::unique_ptr<DeviceWatch> watch_;
  std::unique_ptr<JoyStream> stream_;
  std::unique_ptr<io::ReaderThread> reader_;
};

}  // namespace nacelle::joy
