// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/lifecycle_manager/crew.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::lifecycle_manager {

inline constexpr Duration kReadinessLimit = 10s;  ///< For a condition that sets no timeout.

/// A condition for activating a node: another node is active, and a further condition on that node may have to hold.
struct Dependency {
  std::string node;
  Place where;              ///< In the plan.
  std::string beside = {};  ///< The further condition, for display: "first_message(/scan)". Empty: none.
  /// Returns why the further condition does not hold ("no message yet"); empty if it holds. Null: no further condition.
  /// Polled on the manager's thread.
  std::function<std::string()> missing = {};
  /// Limit for the further condition, counted from the activation of the other node. Waiting for that activation has no
  /// limit of its own: the transitions of the other node have theirs.
  Duration timeout = kReadinessLimit;
};

/// One node of the plan.
struct ManagedNode {
  std::string name;  ///< Fully qualified.
  std::vector<Dependency> after;
  bool activate = true;  ///< False: the manager configures it and does not activate it.
  bool required = true;  ///< False: if it fails, the bring-up continues without it, and no node waits for it.
};

/// Returns the nodes in the order of bring-up: dependencies first, otherwise as listed. The order depends on the plan
/// only.
///
/// Errors: a Problem that names an unknown node (with the nearest name) or the nodes of a cycle.
[[nodiscard]] Result<std::vector<ManagedNode>, Problem> bring_up_order(std::vector<ManagedNode> nodes);

/// One transition that the manager has requested, and its result.
struct Step {
  std::string node;
  Transition transition = Transition::Configure;
  bool success = false;
  std::string reason;  ///< On success the cause ("bring-up", "undo: /lidar could not configure"), on failure the error.
  MonotonicTime ended;
  Duration took{};
  bool left_out = false;  ///< The transition of an optional node failed, and the bring-up continues without the node.
};

struct Outcome {
  bool success = false;
  Problem problem;  ///< On failure: the node, the transition and the reason.
  /// startup(): the active nodes, in the plan's order. deactivate() and cleanup(): see there.
  std::vector<std::string> activated;
};

/// The functions through which the manager acts and reports. All but `trigger` are called on the manager's thread only,
/// and may be empty.
struct Hooks {
  /// Requests a transition and waits for its result. Must not throw.
  /// Threads: on the way up those of the Crew, at most one call per node at a time; on the way down the manager's.
  std::function<TransitionOutcome(const std::string& node, Transition transition)> trigger;
  /// Returns the state of a node; Unknown if it is unloaded. Called by deactivate() and cleanup() only, because a node
  /// may have been stopped or unloaded without the manager. Empty: the manager relies on the last reported states.
  std::function<StateId(const std::string& node)> state;
  /// Returns why the bring-up must be aborted ("interrupted by SIGINT"); empty if it may continue.
  std::function<std::string()> interrupted;
  std::function<void(const std::string& node, Transition transition)> on_begin;
  /// Reports a finished step. During startup() steps are reported in the plan's order, regardless of which ended first.
  std::function<void(const Step& step)> on_step;
  /// Reports, once each, a condition or a transition that has taken longer than 3 s.
  std::function<void(const std::string& node, const std::string& text)> on_wait;
};

/// Brings managed nodes up in order and down in reverse (design D8).
///
/// startup() configures all nodes, then activates them, so that a missing device is detected before anything moves. On
/// the way up, nodes that do not depend on each other change state in parallel; on the way down, one node at a time. If
/// a step of a required node fails, no further step begins, all steps so far are rolled back in reverse order, and the
/// outcome reports the failure.
/// Threads: one caller at a time. The clock is used for timeouts and for the durations of steps.
class LifecycleManager {
 public:
  /// `order` is a result of bring_up_order().
  LifecycleManager(std::vector<ManagedNode> order, Hooks hooks, const Clock& clock);
  ~LifecycleManager();

  [[nodiscard]] Outcome startup(Crew& crew);
  /// Deactivates all active nodes in reverse order. Continues after a failure, and reports the first one.
  /// Outcome::activated holds the nodes that were deactivated, in that order.
  [[nodiscard]] Outcome deactivate();
  /// Cleans up all inactive nodes in the same way.
  [[nodiscard]] Outcome cleanup();

 private:
  struct Entry;
  enum class Readiness { Ready, NotYet, Never };

  [[nodiscard]] Entry* find(const std::string& name);
  void begin(Entry& entry, Transition transition, Crew& crew);
  /// Collects finished steps, and reports those that are next in the plan's order. Returns the number of running steps.
  std::size_t collect(Transition transition, bool goes_on);
  void tell(Entry& entry);
  [[nodiscard]] Readiness readiness(Entry& entry);
  void run_phase(Transition transition, Crew& crew, Outcome& result);
  TransitionOutcome step_down(Entry& entry, Transition transition, const std::string& why);
  void undo(const std::string& why);
  Outcome take_down(Transition transition);

  std::deque<Entry> entries_;
  Hooks hooks_;
  const Clock& clock_;
  MonotonicTime phase_begin_;
};

}  // namespace nacelle::lifecycle_manager
