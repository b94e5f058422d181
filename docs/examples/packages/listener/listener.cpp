// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdint>
#include <memory>
#include <std_msgs/msg/string.hpp>
#include <std_msgs/msg/u_int64.hpp>

#include "nacelle/node/component.hpp"

namespace example {

/// Subscribes to `chatter`, logs at most one text every five seconds and publishes the number of messages on `heard`.
class Listener final : public nacelle::LifecycleNode {
 public:
  explicit Listener(const nacelle::NodeOptions& options) : LifecycleNode("listener", options) {
    publisher_ = create_publisher<std_msgs::msg::UInt64>("heard", nacelle::QoS(10));
    subscription_ = create_subscription<std_msgs::msg::String>(
        "chatter", nacelle::QoS(10), [this](const std_msgs::msg::String& message) { hear(message); });
  }

 private:
  void hear(const std_msgs::msg::String& message) {
    get_logger().info_throttle(std::chrono::seconds{5}, "heard '{}'", message.data);
    std_msgs::msg::UInt64 count;
    count.data = ++count_;
    publisher_->publish(count);
  }

  std::shared_ptr<nacelle::Publisher<std_msgs::msg::UInt64>> publisher_;
  nacelle::Subscription<std_msgs::msg::String>::SharedPtr subscription_;
  std::uint64_t count_ = 0;
};

}  // namespace example

NACELLE_REGISTER_COMPONENT(example::Listener)
