// SPDX-License-Identifier: Apache-2.0
// Leaves a thread-local behind on the thread that runs its callback.
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Hoarder final : public Node {
 public:
  explicit Hoarder(const NodeOptions& options) : Node("hoarder", options) {
    heard_ = create_publisher<std_msgs::msg::String>("heard", QoS(10).transient_local());
    words_ = create_subscription<std_msgs::msg::String>("words", QoS(1).transient_local(),
                                                        [this](const std_msgs::msg::String& word) {
                                                          thread_local std::string hoard;
                                                          hoard += word.data;
                                                          auto heard = heard_->borrow();
                                                          heard->data = hoard;
                                                          heard_->publish(std::move(heard));
                                                        });
  }

 private:
  Publisher<std_msgs::msg::String>::SharedPtr heard_;
  Subscription<std_msgs::msg::String>::SharedPtr words_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Hoarder)
