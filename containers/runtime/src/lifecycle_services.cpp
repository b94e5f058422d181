// SPDX-License-Identifier: Apache-2.0
#include "lifecycle_services.hpp"

#include "nacelle/base/log.hpp"
#include "nacelle/host/lifecycle_graph.hpp"
#include "nacelle/runtime/interface_messages.hpp"
#include "node_services.hpp"
#include "offer.hpp"

namespace nacelle::runtime {
namespace {

using lifecycle_msgs::srv::ChangeState;
using lifecycle_msgs::srv::GetAvailableStates;
using lifecycle_msgs::srv::GetAvailableTransitions;
using lifecycle_msgs::srv::GetState;

void append(GetAvailableTransitions::Response& response, const LifecycleEdge& edge) {
  auto& message = response.available_transitions.emplace_back();
  message.transition.id = edge.id;
  message.transition.label = edge.label;
  message.start_state = message_of(edge.start);
  message.goal_state = message_of(edge.goal);
}

}  // namespace

std::optional<Transition> meant_transition(const lifecycle_msgs::msg::Transition& asked, StateId from) {
  constexpr std::uint8_t kFirstShutdown = 5, kLastShutdown = 7;
  for (const LifecycleEdge& edge : kLifecycleGraph) {
    if (edge.start != from || edge.id > kLastShutdown) continue;
    if (asked.label.empty() ? asked.id != edge.id : asked.label != edge.label) continue;
    return edge.id >= kFirstShutdown ? Transition::Shutdown : static_cast<Transition>(edge.id);
  }
  return std::nullopt;
}

void LifecycleServices::start(NodeRuntime& node, const std::shared_ptr<LifecycleServices>& self) {
  self_ = self;
  node_ = node.identity().fully_qualified();
  change_state_ = offer<ChangeState>(
      node, "change_state",
      [this](const RequestId& id, const ChangeState::Request& asked) { change_state(id, asked.transition); });
  state_ = offer<GetState>(node, "get_state", [this](const GetState::Request&, GetState::Response& told) {
    told.current_state = message_of(desk_.state(id_));
  });
  states_ = offer<GetAvailableStates>(node, "get_available_states",
                                      [](const GetAvailableStates::Request&, GetAvailableStates::Response& told) {
                                        told = {};
                                        for (const StateId state : kLifecycleStates)
                                          told.available_states.push_back(message_of(state));
                                      });
  transitions_ = offer<GetTransitions>(node, "get_available_transitions",
                                       [this](const GetTransitions::Request&, GetTransitions::Response& told) {
                                         told = {};
                                         const StateId state = desk_.state(id_);
                                         for (const LifecycleEdge& edge : kLifecycleGraph) {
                                           if (edge.start == state) append(told, edge);
                                         }
                                       });
  graph_ = offer<GetTransitions>(node, "get_transition_graph",
                                 [](const GetTransitions::Request&, GetTransitions::Response& told) {
                                   told = {};
                                   for (const LifecycleEdge& edge : kLifecycleGraph) append(told, edge);
                                 });
}

// A transition may take half a minute, so it does not run on the answering thread.
void LifecycleServices::change_state(const RequestId& id, const lifecycle_msgs::msg::Transition& asked) {
  const auto run = [self = self_, desk = &desk_, node = id_, id, asked] {
    const auto services = self.lock();
    if (!services) return;  // unloaded meanwhile
    const StateId from = desk->state(node);
    const auto transition = meant_transition(asked, from);
    ChangeState::Response response;
    if (transition) {
      const TransitionOutcome outcome = desk->trigger(node, *transition);
      response.success = outcome.success;
      if (!outcome.success)
        Logger{"container"}.warn("{}: change_state did not {}: {}", services->node_, nacelle::to_text(*transition),
                                 outcome.reason);
    } else {
      Logger{"container"}.warn("{}: change_state is asked for transition {} '{}', which does not lead on from {}",
                               services->node_, asked.id, asked.label, nacelle::to_text(from));
    }
    services->change_state_->send_response(id, std::move(response));
  };
  if (desk_.lanes().push(id_, run)) return;
  change_state_->send_response(id, ChangeState::Response{});
}

}  // namespace nacelle::runtime
