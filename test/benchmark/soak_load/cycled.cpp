// SPDX-License-Identifier: Apache-2.0
// What is loaded and unloaded: one of everything that a component can declare, and all of it in use.
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::soak {

using std_msgs::msg::String;
using std_srvs::srv::Trigger;

class Cycled final : public LifecycleNode {
 public:
  explicit Cycled(const NodeOptions& options) : LifecycleNode("cycled", options) {
    declare_parameter("greeting", "hello");
    declare_parameter("rate_hz", 1000.0, {.description = "Of the timer."});
    declare_parameter("names", std::vector<std::string>{"a", "b", "c"});
    echo_ = create_publisher<String>("echo", QoS(10));
    latched_ = create_publisher<String>("latched", QoS(1).transient_local());
    ticks_ = create_publisher<String>("ticks", QoS(10));
    word_ = create_subscription<String>("word", QoS(10), [this](const String& word) { repeat(word); });
    timer_ = create_wall_timer(from_seconds(1.0 / get<double>("rate_hz")), [this] { say(*ticks_, "tick"); });
    service_ = create_service<Trigger>("~/greet", [this](const Trigger::Request&, Trigger::Response& response) {
      response.success = true;
      response.message = get<std::string>("greeting");
    });
    ping_ = create_client<Trigger>("/neighbour/ping");
    frame_ = claim_frame("soak", "cycled");
  }

 private:
  CallbackReturn on_activate(const State&) override {
    say(*latched_, get<std::string>("greeting"));
    return CallbackReturn::SUCCESS;
  }
  void repeat(const String& word) {
    const auto begin = steady_clock().now();
    // Its answer comes after the unload has begun, or never.
    static_cast<void>(ping_->async_send_request({}, [this](const Trigger::Response*) { ++answers_; }));
    say(*echo_, word.data);
    duration_.record(steady_clock().now() - begin);
  }
  static void say(Publisher<String>& publisher, const std::string& text) {
    auto message = publisher.borrow();
    message->data = text;
    publisher.publish(std::move(message));
  }

  Publisher<String>::SharedPtr echo_, latched_, ticks_;
  Subscription<String>::SharedPtr word_;
  Timer::SharedPtr timer_;
  Service<Trigger>::SharedPtr service_;
  Client<Trigger>::SharedPtr ping_;
  std::unique_ptr<FrameClaim> frame_;
  DurationHistogram& duration_ = create_histogram("repeat");
  int answers_ = 0;
};

}  // namespace nacelle::soak

NACELLE_REGISTER_COMPONENT(nacelle::soak::Cycled)
