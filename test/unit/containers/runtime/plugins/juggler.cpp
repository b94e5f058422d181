// SPDX-License-Identifier: Apache-2.0
// Several things at once: two callbacks that meet if their groups may overlap, a service, and a caller that waits for it.
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Juggler final : public LifecycleNode {
 public:
  using SetBool = std_srvs::srv::SetBool;
  using String = std_msgs::msg::String;

  explicit Juggler(const NodeOptions& options) : LifecycleNode("juggler", options) {
    limit_ = std::chrono::milliseconds(declare_parameter<int>("limit_ms", 20000));
    said_ = create_publisher<String>("said", QoS(100).transient_local());
    reentrant_ = create_callback_group(CallbackGroupType::Reentrant);
    const SubscriptionOptions together{.callback_group = reentrant_};
    const auto meet = [this](const String&) { say(meet_ ? "met" : "was alone"); };
    left_ = create_subscription<String>(
        "left", QoS(10),
        [this, meet](const String& s) {
          wait_for_other();
          meet(s);
        },
        together);
    right_ = create_subscription<String>(
        "right", QoS(10),
        [this, meet](const String& s) {
          wait_for_other();
          meet(s);
        },
        together);
    server_ = create_service<SetBool>(
        "answer", [](const SetBool::Request&, SetBool::Response& response) { response.message = "answered"; },
        reentrant_);
    others_ = create_callback_group(CallbackGroupType::MutuallyExclusive);
    client_ = create_client<SetBool>("answer", others_);
    own_client_ = create_client<SetBool>("answer");
    ask_ = create_subscription<String>("ask", QoS(10), [this](const String& how) {
      auto future = (how.data == "own group" ? own_client_ : client_)->async_send_request({});
      if (!future.valid()) return say("no server");
      try {
        say(future.wait_for(limit_) == std::future_status::ready ? future.get()->message : "no answer in time");
      } catch (const exceptions::WaitsForItself& e) { say(e.what()); }
    });
    ticks_ = create_wall_timer(
        1ms, [this] { ++ticked_; }, reentrant_);
  }

 private:
  void wait_for_other() {
    std::unique_lock lock(mutex_);
    ++here_;
    changed_.notify_all();
    meet_ = changed_.wait_for(lock, limit_, [this] { return here_ == 2; });
  }
  void say(const std::string& text) {
    const std::lock_guard lock(saying_);  // a publisher is used by one thread at a time
    auto message = said_->borrow();
    message->data = text;
    said_->publish(std::move(message));
  }
  Duration limit_{};
  std::mutex mutex_, saying_;
  std::condition_variable changed_;
  int here_ = 0;
  std::atomic<bool> meet_{false};
  std::atomic<int> ticked_{0};
  CallbackGroup::SharedPtr reentrant_, others_;
  Publisher<String>::SharedPtr said_;
  Subscription<String>::SharedPtr left_, right_, ask_;
  Service<SetBool>::SharedPtr server_;
  Client<SetBool>::SharedPtr client_, own_client_;
  Timer::SharedPtr ticks_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Juggler)
