// SPDX-License-Identifier: Apache-2.0
// Sends a goal of order `order` to `series` once it is active and the server too; says on ~/outcome how it ended.
#include <example_interfaces/action/fibonacci.hpp>
#include <std_msgs/msg/string.hpp>

#include "nacelle/node/action_client.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::test {

using example_interfaces::action::Fibonacci;
using std_msgs::msg::String;

class SeriesClient final : public LifecycleNode {
 public:
  explicit SeriesClient(const NodeOptions& options) : LifecycleNode("series_client", options) {
    declare_parameter("order", 5);
    outcome_ = create_publisher<String>("~/outcome", QoS(1).transient_local());
    client_ = action::create_client<Fibonacci>(this, "series");
    look_ = create_wall_timer(20ms, [this] {
      if (!client_->action_server_is_ready()) return;
      look_->cancel();
      send();
    });
  }

 private:
  using Client = action::Client<Fibonacci>;
  void send() {
    Fibonacci::Goal goal;
    goal.order = static_cast<std::int32_t>(get<std::int64_t>("order"));
    Client::SendGoalOptions options;
    options.goal_response_callback = [this](const auto& handle) {
      if (!handle) say("REJECTED");
    };
    options.result_callback = [this](const Client::WrappedResult& result) {
      say(to_text(static_cast<action::GoalStatus>(result.code)) + std::string{" "} +
          std::to_string(result.result->sequence.size()));
    };
    client_->async_send_goal(goal, options);
  }
  void say(const std::string& text) {
    String message;
    message.data = text;
    outcome_->publish(message);
  }

  std::shared_ptr<Publisher<String>> outcome_;
  std::shared_ptr<Client> client_;
  Timer::SharedPtr look_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::SeriesClient)
