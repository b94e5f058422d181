// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>

#include "nacelle/host/lifecycle_state.hpp"
#include "nacelle/node/node.hpp"

namespace nacelle {

/// A managed node: ROS 2's state machine, plus reasons (design D8).
///
/// While it is not active, no topic callback, timer or service of it runs and nothing it publishes leaves (dropped, counted).
/// The callbacks run on the component's executor and may take their time: the others move to a spare thread meanwhile.
/// Source: state machine of rcl_lifecycle, `default_state_machine.c`.
class LifecycleNode : public Node {
 public:
  LifecycleNode(const std::string& default_name, const NodeOptions& options);

  [[nodiscard]] State get_current_state() const { return State{state_.load(std::memory_order_acquire)}; }

  /// Reports that the component cannot continue. Error processing follows on its executor. Legal in every state, from any thread.
  /// `code` is a short constant word (SERIAL_LOST); `text` tells the user what happened and what to do.
  void fault(std::string code, std::string text) { host().report_fault(std::move(code), std::move(text)); }
  /// Opens a fault that the component will repair itself (a pulled cable). The state stays, `on_fault` is not applied, and
  /// `nacelle faults` and /diagnostics show it until close_fault(). A second call with that code replaces the text. From any thread.
  void open_fault(std::string code, std::string text) { host().open_fault(std::move(code), std::move(text)); }
  /// Closes a fault. Ignores a code that is not open. From any thread.
  void close_fault(const std::string& code) { host().close_fault(code); }

  /// Called by the container on the component's executor, by tests directly. Exceptions of callbacks count as ERROR.
  TransitionOutcome trigger(Transition transition);
  /// Error processing for a fault: leaves the node unconfigured, or finalized if on_error fails.
  TransitionOutcome process_fault(const FaultReason& reason);

 protected:
  virtual CallbackReturn on_configure(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_cleanup(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_activate(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_deactivate(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_shutdown(const State&) { return CallbackReturn::SUCCESS; }
  virtual CallbackReturn on_error(const State&) { return CallbackReturn::SUCCESS; }

  /// `return refuse(problem);` fails the transition with a reason that bring-up shows.
  CallbackReturn refuse(const Problem& problem) {
    reason_ = problem.text();
    return CallbackReturn::FAILURE;
  }
  CallbackReturn refuse(std::string reason) {
    reason_ = std::move(reason);
    return CallbackReturn::FAILURE;
  }

 private:
  CallbackReturn guarded(CallbackReturn (LifecycleNode::*callback)(const State&), StateId from);
  TransitionOutcome run_error_processing(StateId from);
  void enter(StateId state);

  std::atomic<StateId> state_{StateId::Unconfigured};
  std::string reason_;
};

}  // namespace nacelle
