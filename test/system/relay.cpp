// SPDX-License-Identifier: Apache-2.0
// Reads /chatter and publishes /nchatter: two names that are nearly the same, both on purpose.
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Relay final : public LifecycleNode {
 public:
  explicit Relay(const NodeOptions& options)
      : LifecycleNode("relay", options),
        out_(create_publisher<std_msgs::msg::String>("nchatter", QoS(10))),
        in_(create_subscription<std_msgs::msg::String>(
            "chatter", QoS(10), [this](const std_msgs::msg::String& text) { out_->publish(text); })) {}

 private:
  Publisher<std_msgs::msg::String>::SharedPtr out_;
  Subscription<std_msgs::msg::String>::SharedPtr in_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Relay)
