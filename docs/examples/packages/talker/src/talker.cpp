// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <std_msgs/msg/string.hpp>
#include <string>
#include <utility>

#include "nacelle/node/component.hpp"

namespace example {

/// Publishes "hello 1", "hello 2", ... on `chatter`, one every `period` seconds.
class Talker final : public nacelle::LifecycleNode {
 public:
  explicit Talker(const nacelle::NodeOptions& options) : LifecycleNode("talker", options) {
    const double period_s = declare_parameter("period", 0.5,
                                              {.description = "s, between two messages",
                                               .read_only = true,
                                               .floating_point_range = nacelle::FloatingPointRange{0.001, 60.0, 0.0}});
    publisher_ = create_publisher<std_msgs::msg::String>("chatter", nacelle::QoS(10));
    timer_ = create_wall_timer(nacelle::from_seconds(period_s), [this] { say(); });
  }

 private:
  void say() {
    auto message = publisher_->borrow();  // from the publisher's pool: no allocation
    if (!message) return;                 // pool exhausted: subscribers still hold every message
    message->data = "hello " + std::to_string(++count_);
    publisher_->publish(std::move(message));
  }

  std::shared_ptr<nacelle::Publisher<std_msgs::msg::String>> publisher_;
  nacelle::Timer::SharedPtr timer_;
  int count_ = 0;
};

}  // namespace example

NACELLE_REGISTER_COMPONENT(example::Talker)
