// SPDX-License-Identifier: Apache-2.0
// Does not return from the place that the parameter sleep_in names, until the test lets it: says so with one byte on the descriptor
// `entered`, and waits for one on `release`.
#include <unistd.h>

#include <std_msgs/msg/string.hpp>
#include <std_srvs/srv/set_bool.hpp>

#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Sleeper final : public LifecycleNode {
 public:
  explicit Sleeper(const NodeOptions& options) : LifecycleNode("sleeper", options) {
    declare_parameter("sleep_in", "");
    declare_parameter("entered", -1);
    declare_parameter("release", -1);
    frame_ = claim_frame("bed", "pillow");
    words_ = create_subscription<std_msgs::msg::String>("words", QoS(1).transient_local(),
                                                        [this](const std_msgs::msg::String& word) {
                                                          if (word.data == "fault")
                                                            return fault("TOLD_TO", "a fault on command");
                                                          if (word.data == "open")
                                                            return open_fault("CABLE", "it is pulled");
                                                          if (word.data == "close") return close_fault("CABLE");
                                                          maybe_sleep("callback");
                                                        });
    service_ = create_service<std_srvs::srv::SetBool>(
        "~/enable", [this](const std_srvs::srv::SetBool::Request&, std_srvs::srv::SetBool::Response& response) {
          maybe_sleep("service");
          response.message = "well rested";
        });
    maybe_sleep("constructor");
  }
  ~Sleeper() override { maybe_sleep("destructor"); }

 private:
  CallbackReturn on_configure(const State&) override {
    maybe_sleep("transition");
    return CallbackReturn::SUCCESS;
  }
  CallbackReturn on_error(const State&) override {
    maybe_sleep("on_error");
    return CallbackReturn::SUCCESS;
  }
  void maybe_sleep(const char* where) {
    if (get<std::string>("sleep_in") != where) return;
    char byte = 'z';
    static_cast<void>(!::write(static_cast<int>(get<std::int64_t>("entered")), &byte, 1));
    static_cast<void>(!::read(static_cast<int>(get<std::int64_t>("release")), &byte, 1));
  }
  std::unique_ptr<FrameClaim> frame_;
  Subscription<std_msgs::msg::String>::SharedPtr words_;
  Service<std_srvs::srv::SetBool>::SharedPtr service_;
};

}  // namespace nacelle::test

NACELLE_REGISTER_COMPONENT(nacelle::test::Sleeper)
