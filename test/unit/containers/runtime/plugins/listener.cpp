// SPDX-License-Identifier: Apache-2.0
// Keeps the last word it heard (so that its sender's messages outlive the sender), faults on command, asks a service.
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Listener final : public LifecycleNode {
 public:
  explicit Listener(const NodeOptions& options) : LifecycleNode("listener", options) {
    heard_ = create_publisher<std_msgs::msg::String>("heard", QoS(10).transient_local());
    words_ = create_subscription<std_msgs::msg::String>("words", QoS(1).transient_local(),
                                                        [this](std::shared_ptr<const std_msgs::msg::String> word) {
                                                          if (word->data == "throw")
                                                            throw std::runtime_error("cannot bear that word");
                                                          if (word->data == "fault")
                                                            return fault("BAD_WORD", "heard a bad word");
                                                          kept_ = std::move(word);
                                                          say(kept_->data);
                                                        });
    client_ = create_client<std_srvs::srv::SetBool>("/talker/enable");
    ask_ = create_subscription<std_msgs::msg::String>("ask", QoS(10), [this](const std_msgs::msg::String&) {
      const bool sent = client_->async_send_request({}, [this](const std_srvs::srv::SetBool::Response* response) {
        say(response != nullptr ? "answer " + response->message : "no answer");
      });
      if (!sent) say("no server");
    });
  }

 private:
  void say(const std::string& text) {
    auto message = heard_->borrow();
    message->data = text;
    heard_->publish(std::move(message));
  }
  Publisher<std_msgs::msg::String>::SharedPtr heard_;
  Subscription<std_msgs::msg::String>::SharedPtr words_, ask_;
  Client<std_srvs::srv::SetBool>::SharedPtr client_;
  std::shared_ptr<const std_msgs::msg::String> kept_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Listener)
