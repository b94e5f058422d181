// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <lifecycle_msgs/srv/change_state.hpp>
#include <lifecycle_msgs/srv/get_available_states.hpp>
#include <lifecycle_msgs/srv/get_available_transitions.hpp>
#include <lifecycle_msgs/srv/get_state.hpp>
#include <memory>
#include <optional>
#include <string>

#include "nacelle/node/lifecycle_node.hpp"
#include "nacelle/node/service.hpp"
#include "node_runtime.hpp"

namespace nacelle::runtime {

class NodeServices;

/// rclcpp_lifecycle's five services of a managed node. change_state answers when the transition is over; the others
/// answer at once, also during a transition.
class LifecycleServices {
 public:
  LifecycleServices(NodeServices& desk, std::uint64_t id) : desk_(desk), id_(id) {}
  /// `self` keeps everything alive while an answer is pending.
  void start(NodeRuntime& node, const std::shared_ptr<LifecycleServices>& self);

 private:
  using GetTransitions = lifecycle_msgs::srv::GetAvailableTransitions;
  void change_state(const RequestId& id, const lifecycle_msgs::msg::Transition& asked);

  NodeServices& desk_;
  const std::uint64_t id_;
  std::string node_;
  std::weak_ptr<LifecycleServices> self_;
  Service<lifecycle_msgs::srv::ChangeState>::SharedPtr change_state_;
  Service<lifecycle_msgs::srv::GetState>::SharedPtr state_;
  Service<lifecycle_msgs::srv::GetAvailableStates>::SharedPtr states_;
  Service<GetTransitions>::SharedPtr transitions_, graph_;
};

/// Returns the transition that a request means in a state: by its label if it has one, else by its id. Returns nothing
/// if no such transition can be requested there. Pure.
[[nodiscard]] std::optional<Transition> meant_transition(const lifecycle_msgs::msg::Transition& asked, StateId from);

}  // namespace nacelle::runtime
