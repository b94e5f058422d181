// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "nacelle/node/node.hpp"

namespace nacelle {

/// lifecycle_msgs' ids of states.
enum class StateId : std::uint8_t {
  Unknown = 0,
  Unconfigured = 1,
  Inactive = 2,
  Active = 3,
  Finalized = 4,
  Configuring = 10,
  CleaningUp = 11,
  ShuttingDown = 12,
  Activating = 13,
  Deactivating = 14,
  ErrorProcessing = 15,
};
/// lifecycle_msgs' labels: "unconfigured", "inactive", ...
[[nodiscard]] const char* to_text(StateId state);

/// The state a callback comes from.
class State {
 public:
  explicit State(StateId id) : id_(id) {}
  [[nodiscard]] std::uint8_t id() const { return static_cast<std::uint8_t>(id_); }
  [[nodiscard]] StateId state() const { return id_; }
  [[nodiscard]] std::string label() const { return to_text(id_); }

 private:
  StateId id_;
};

/// Return codes of lifecycle_msgs/msg/Transition.
enum class CallbackReturn : std::uint8_t { SUCCESS = 97, FAILURE = 98, ERROR = 99 };

/// What one can ask a managed node to do (lifecycle_msgs ids 1 to 5; shutdown stands for 5, 6 and 7).
enum class Transition : std::uint8_t { Configure = 1, Cleanup = 2, Activate = 3, Deactivate = 4, Shutdown = 5 };
[[nodiscard]] const char* to_text(Transition transition);
/// "configure", "cleanup", "activate", "deactivate", "shutdown". Returns false on another word.
[[nodiscard]] bool parse_transition(std::string_view text, Transition& transition);

/// Why a transition did not do what was asked.
struct TransitionOutcome {
  bool success = false;
  StateId state = StateId::Unknown;  ///< Where the node is now.
  std::string reason;  ///< Empty on success: the component's own words, an exception's text, or what was not allowed.
};

/// Why a node is faulted.
struct FaultReason {
  std::string code, text;
};

/// A managed node: ROS 2's state machine, plus reasons (design D8).
///
/// While it is not active, no topic callback, timer or service of it runs and nothing it publishes leaves (dropped, counted).
/// The callbacks run on the component's executor and may take their time: the others move to a spare thread meanwhile.
/// Source: state machine of rcl_lifecycle, `default_state_machine.c`.
class LifecycleNode : public Node {
 public:
  LifecycleNode(const std::string& default_name, const NodeOptions& options);

  [[nodiscard]] State get_current_state() const { return State{state_.load(std::memory_order_acquire)}; }

  /// The component cannot go on: error processing follows on its executor. Legal in every state, from any thread.
  /// `code` is a short constant word (SERIAL_LOST), `text` tells a person what happened and what to do.
  void fault(std::string code, std::string text) { host().report_fault(std::move(code), std::move(text)); }
  /// Something is wrong that the component mends itself (a cable that was pulled): it stays as it is, `on_fault` is not applied,
  /// and faults and /diagnostics show it until close_fault() of the same code. Again with that code: another text. From any thread.
  void open_fault(std::string code, std::string text) { host().open_fault(std::move(code), std::move(text)); }
  /// Does nothing for a code that is not open. From any thread.
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
