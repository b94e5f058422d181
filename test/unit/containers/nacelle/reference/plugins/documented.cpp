// SPDX-License-Identifier: Apache-2.0
// Declares one of each thing that the reference of components lists, and more of them with a parameter.
#include <example_interfaces/action/fibonacci.hpp>
#include <std_msgs/msg/bool.hpp>
#include <std_srvs/srv/trigger.hpp>

#include "nacelle/node/action_server.hpp"
#include "nacelle/node/component.hpp"

namespace nacelle::test {

class Documented final : public Node {
  using Bool = std_msgs::msg::Bool;
  using Fibonacci = example_interfaces::action::Fibonacci;
  using Trigger = std_srvs::srv::Trigger;

 public:
  explicit Documented(const NodeOptions& options) : Node("documented", options) {
    declare_parameter("speed", 1.5,
                      {.description = "m/s|forwards",
                       .additional_constraints = "not <0>",
                       .read_only = true,
                       .floating_point_range = FloatingPointRange{0.0, 2.0, 0.5}});
    declare_parameter("count", 3, {.description = "", .integer_range = IntegerRange{1, 9}});
    declare_parameter("line", ParameterType::String);
    declare_device_use("/dev/null", "line");
    const bool has_more = declare_parameter("more", false);
    if (has_more) {
      declare_parameter("extra", "x");
      second_ = create_publisher<Bool>("/all", QoS(1).transient_local());
    }
    first_ = create_publisher<Bool>("relative", QoS(7));
    twin_ = create_publisher<Bool>("relative", QoS(7));
    named_ = create_subscription<Bool>("documented/relative", QoS(1), [](const Bool&) {});
    heard_ = create_subscription<Bool>("~/own", QoS(2).best_effort(), [](const Bool&) {});
    service_ = create_service<Trigger>("go", [](const Trigger::Request&, Trigger::Response&) {});
    client_ = create_client<Trigger>("/other/go");
    claim_ = claim_frame("a", "b", FrameClaimKind::Fallback, Place::of_parameter("more"));
    action_ = action::create_server<Fibonacci>(
        this, "~/series",
        [](const action::GoalUUID&, const std::shared_ptr<const Fibonacci::Goal>&) {
          return action::GoalResponse::REJECT;
        },
        [](const std::shared_ptr<action::ServerGoalHandle<Fibonacci>>&) { return action::CancelResponse::ACCEPT; },
        [](const std::shared_ptr<action::ServerGoalHandle<Fibonacci>>&) {});
  }

 private:
  std::shared_ptr<Publisher<Bool>> first_, twin_, second_;
  std::shared_ptr<Subscription<Bool>> named_, heard_;
  std::shared_ptr<Service<Trigger>> service_;
  std::shared_ptr<Client<Trigger>> client_;
  std::unique_ptr<FrameClaim> claim_;
  std::shared_ptr<action::Server<Fibonacci>> action_;
};

class WronglyDocumented final : public Node {
 public:
  explicit WronglyDocumented(const NodeOptions& options) : Node("wrongly_documented", options) {}
};

}  // namespace nacelle::test

template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::test::Documented>{
    .purpose = "Shows everything.", .devices = "a zero sink", .also_with = "more:=true"};
template <>
inline constexpr nacelle::ComponentAbout nacelle::kComponentAbout<nacelle::test::WronglyDocumented>{.also_with =
                                                                                                        "more=true"};

NACELLE_REGISTER_COMPONENT(nacelle::test::Documented, nacelle::test::WronglyDocumented)
