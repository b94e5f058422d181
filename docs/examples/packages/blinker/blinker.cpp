// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <std_msgs/msg/bool.hpp>
#include <vector>

#include "nacelle/node/component.hpp"

namespace example {

using nacelle::CallbackReturn;
using nacelle::State;

/// Publishes `led`, which blinks with `rate` while the node is active. `rate` may be set at any time, and is
/// refused outside of 0.1 to 10 Hz.
class Blinker final : public nacelle::LifecycleNode {
 public:
  explicit Blinker(const nacelle::NodeOptions& options) : LifecycleNode("blinker", options) {
    declare_parameter("rate", 2.0,
                      {.description = "Hz; on and off again is one period",
                       .floating_point_range = nacelle::FloatingPointRange{0.1, 10.0, 0.0}});
    // The range is checked before this. It is the only callback, so none can refuse the value afterwards.
    on_set_ = add_on_set_parameters_callback([this](const std::vector<nacelle::Parameter>& parameters) {
      for (const auto& parameter : parameters) {
        if (parameter.get_name() == "rate" && timer_) start(parameter.as_double());
      }
      return nacelle::SetParametersResult{};
    });
    led_ = create_publisher<std_msgs::msg::Bool>("led", nacelle::QoS(1).transient_local());
  }

 private:
  CallbackReturn on_activate(const State&) override {
    start(get<double>("rate"));
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_deactivate(const State&) override {
    timer_.reset();
    return CallbackReturn::SUCCESS;
  }

  void start(double rate_hz) {
    timer_ = create_wall_timer(nacelle::from_seconds(0.5 / rate_hz), [this] { toggle(); });
  }
  void toggle() {
    is_on_ = !is_on_;
    std_msgs::msg::Bool message;
    message.data = is_on_;
    led_->publish(message);
  }

  nacelle::OnSetParametersCallbackHandle::SharedPtr on_set_;
  std::shared_ptr<nacelle::Publisher<std_msgs::msg::Bool>> led_;
  nacelle::Timer::SharedPtr timer_;
  bool is_on_ = false;
};

}  // namespace example

NACELLE_REGISTER_COMPONENT(example::Blinker)
