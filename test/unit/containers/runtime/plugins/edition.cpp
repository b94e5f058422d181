// SPDX-License-Identifier: Apache-2.0
// Built twice, with EDITION 1 and 2: the same component before and after a change.
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Edition final : public Node {
 public:
  explicit Edition(const NodeOptions& options) : Node("edition", options) {
    told_ = create_publisher<std_msgs::msg::String>("told", QoS(10));
    asked_ = create_subscription<std_msgs::msg::String>("asked", QoS(10), [this](const std_msgs::msg::String&) {
      auto word = told_->borrow();
      word->data = get_name() + " is edition " + std::to_string(EDITION);
      told_->publish(std::move(word));
    });
  }

 private:
  Publisher<std_msgs::msg::String>::SharedPtr told_;
  Subscription<std_msgs::msg::String>::SharedPtr asked_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Edition)
