// SPDX-License-Identifier: Apache-2.0
// Publishes a latched word when it becomes active, counts on a timer, and answers a service.
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Talker final : public LifecycleNode {
 public:
  explicit Talker(const NodeOptions& options) : LifecycleNode("talker", options) {
    declare_parameter("word", "hello");
    declare_parameter("rate", 100.0,
                      {.description = "Hz", .floating_point_range = FloatingPointRange{1.0, 1000.0, 0.0}});
    declare_parameter("refuse", "");
    declare_parameter("fault_while_activating", false);
    words_ = create_publisher<std_msgs::msg::String>("words", QoS(1).transient_local());
    ticks_ = create_publisher<std_msgs::msg::String>("ticks", QoS(10));
    timer_ = create_wall_timer(from_seconds(1.0 / get<double>("rate")), [this] {
      auto tick = ticks_->borrow();
      tick->data = "tick";
      ticks_->publish(std::move(tick));
    });
    service_ = create_service<std_srvs::srv::SetBool>(
        "~/enable", [this](const std_srvs::srv::SetBool::Request& request, std_srvs::srv::SetBool::Response& response) {
          response.success = request.data;
          response.message = get<std::string>("word");
        });
  }

 private:
  CallbackReturn on_configure(const State&) override {
    if (const auto why = get<std::string>("refuse"); why == "throw")
      throw std::runtime_error("the device burns");
    else if (!why.empty())
      return refuse(Problem{"parameter refuse", "is '" + why + "'", "leave it empty"});
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_activate(const State&) override {
    auto word = words_->borrow();
    word->data = get<std::string>("word");
    words_->publish(std::move(word));
    if (get<bool>("fault_while_activating")) fault("LINE_LOST", "the cable was pulled");
    return CallbackReturn::SUCCESS;
  }

  Publisher<std_msgs::msg::String>::SharedPtr words_, ticks_;
  Timer::SharedPtr timer_;
  Service<std_srvs::srv::SetBool>::SharedPtr service_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Talker)
