// SPDX-License-Identifier: Apache-2.0
// The component that stays: hears and calls the one that is loaded and unloaded, and says with each tick of its 1 kHz timer by how
// much the tick was late, and how much of that its thread waited for a CPU.
#include <geometry_msgs/msg/point.hpp>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "lateness.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::soak {

using geometry_msgs::msg::Point;
using std_msgs::msg::String;
using std_srvs::srv::Trigger;

class Neighbour final : public LifecycleNode {
 public:
  explicit Neighbour(const NodeOptions& options) : LifecycleNode("neighbour", options) {
    lateness_ = create_publisher<Point>("lateness", QoS(1000));
    ticks_ = create_subscription<String>("ticks", QoS(10), [this](const String&) { ++heard_; });
    latched_ = create_subscription<String>("latched", QoS(1).transient_local(), [this](const String&) { ++heard_; });
    ping_ = create_service<Trigger>("~/ping", [](const Trigger::Request&, Trigger::Response&) {});
    greet_ = create_client<Trigger>("/cycled/greet");
    timer_ = create_wall_timer(1ms, [this] { tick(); });
  }

 private:
  CallbackReturn on_activate(const State&) override {
    timer_->reset();
    meter_.restart(steady_clock().now(), 1ms);
    return CallbackReturn::SUCCESS;
  }
  void tick() {
    const Lateness now = meter_.tick(steady_clock().now());
    auto report = lateness_->borrow();
    report->x = static_cast<double>(now.late.count());
    report->y = static_cast<double>(now.waited_for_cpu.count());
    lateness_->publish(std::move(report));
    static_cast<void>(greet_->async_send_request({}, [this](const Trigger::Response*) { ++heard_; }));
  }

  Publisher<Point>::SharedPtr lateness_;
  Subscription<String>::SharedPtr ticks_, latched_;
  Service<Trigger>::SharedPtr ping_;
  Client<Trigger>::SharedPtr greet_;
  Timer::SharedPtr timer_;
  LatenessMeter meter_;
  std::uint64_t heard_ = 0;
};

}  // namespace nacelle::soak

NACELLE_REGISTER_COMPONENT(nacelle::soak::Neighbour)
