// SPDX-License-Identifier: Apache-2.0
#include "nacelle/node/lifecycle_node.hpp"

#include <fmt/format.h>

#include <cctype>
#include <exception>
#include <utility>

#include "nacelle/host/state_watch.hpp"

namespace nacelle {
namespace {

// One row per transition that can be asked for. Source: rcl_lifecycle (jazzy), default_state_machine.c.
struct Edge {
  Transition transition;
  StateId from, through, success, failure;
};
constexpr Edge kEdges[] = {
    {Transition::Configure, StateId::Unconfigured, StateId::Configuring, StateId::Inactive, StateId::Unconfigured},
    {Transition::Cleanup, StateId::Inactive, StateId::CleaningUp, StateId::Unconfigured, StateId::Inactive},
    {Transition::Activate, StateId::Inactive, StateId::Activating, StateId::Active, StateId::Inactive},
    {Transition::Deactivate, StateId::Active, StateId::Deactivating, StateId::Inactive, StateId::Active},
    {Transition::Shutdown, StateId::Unconfigured, StateId::ShuttingDown, StateId::Finalized, StateId::Finalized},
    {Transition::Shutdown, StateId::Inactive, StateId::ShuttingDown, StateId::Finalized, StateId::Finalized},
    {Transition::Shutdown, StateId::Active, StateId::ShuttingDown, StateId::Finalized, StateId::Finalized},
};

std::string allowed_from(StateId state) {
  std::string names;
  for (const auto& edge : kEdges) {
    if (edge.from == state) names += (names.empty() ? "" : ", ") + std::string(to_text(edge.transition));
  }
  return names.empty() ? "nothing" : names;
}

}  // namespace

LifecycleNode::LifecycleNode(const std::string& default_name, const NodeOptions& options)
    : Node(default_name, options) {
  host().set_active(false);
}

void LifecycleNode::enter(StateId state) { StateWatch::tell(state_.exchange(state, std::memory_order_acq_rel), state); }

CallbackReturn LifecycleNode::guarded(CallbackReturn (LifecycleNode::*callback)(const State&), StateId from) {
  try {
    return (this->*callback)(State{from});
  } catch (const std::exception& e) { reason_ = e.what(); } catch (...) {
    reason_ = "an exception other than a std::exception";
  }
  return CallbackReturn::ERROR;
}

TransitionOutcome LifecycleNode::trigger(Transition transition) {
  const StateId from = state_.load(std::memory_order_acquire);
  const Edge* edge = nullptr;
  for (const auto& candidate : kEdges) {
    if (candidate.transition == transition && candidate.from == from) edge = &candidate;
  }
  if (edge == nullptr) {
    return {
        false, from,
        fmt::format("cannot {} from state {}; allowed is {}", to_text(transition), to_text(from), allowed_from(from))};
  }
  reason_.clear();
  enter(edge->through);
  // The gate closes before deactivation's callback and opens before activation's: a component may publish from on_activate,
  // and its own I/O thread may already run; nothing leaves any more once deactivation has begun.
  CallbackReturn result = CallbackReturn::ERROR;
  switch (transition) {
    case Transition::Configure: result = guarded(&LifecycleNode::on_configure, from); break;
    case Transition::Cleanup: result = guarded(&LifecycleNode::on_cleanup, from); break;
    case Transition::Activate:
      host().set_active(true);
      result = guarded(&LifecycleNode::on_activate, from);
      if (result != CallbackReturn::SUCCESS) close_gate();
      break;
    case Transition::Deactivate:
      close_gate();
      result = guarded(&LifecycleNode::on_deactivate, from);
      if (result == CallbackReturn::FAILURE) host().set_active(true);
      break;
    case Transition::Shutdown:
      close_gate();
      result = guarded(&LifecycleNode::on_shutdown, from);
      break;
  }
  if (result == CallbackReturn::ERROR) return run_error_processing(from);
  const bool success = result == CallbackReturn::SUCCESS;
  enter(success ? edge->success : edge->failure);
  if (!success && reason_.empty())
    reason_ = fmt::format("on_{} returned FAILURE without a reason", to_text(transition));
  return {success, state_.load(), success ? std::string{} : reason_};
}

TransitionOutcome LifecycleNode::run_error_processing(StateId from) {
  std::string cause = reason_.empty() ? "a callback returned ERROR without a reason" : reason_;
  close_gate();
  enter(StateId::ErrorProcessing);
  const bool recovered = guarded(&LifecycleNode::on_error, from) == CallbackReturn::SUCCESS;
  enter(recovered ? StateId::Unconfigured : StateId::Finalized);
  return {false, state_.load(), std::move(cause)};
}

TransitionOutcome LifecycleNode::process_fault(const FaultReason& reason) {
  reason_ = reason.code + ": " + reason.text;
  return run_error_processing(state_.load(std::memory_order_acquire));
}

}  // namespace nacelle
