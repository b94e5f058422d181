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

inline constexpr Duration kReadinessLimit = 10s;  ///< For a condition without a timeout of its own.

/// What must hold before a node is activated: another one is active, and perhaps something that it does has been seen.
struct Dependency {
  std::string node;
  Place where;              ///< In the plan.
  std::string beside = {};  ///< What must hold beside it: "first_message(/scan)". Empty: nothing.
  /// What that still lacks ("no message yet"); empty if it holds. Called on the manager's thread, again and again.
  std::function<std::string()> missing = {};
  /// How long at most, from the moment at which the node is active. Being active itself takes as long as its transitions may.
  Duration timeout = kReadinessLimit;
};

/// One node of the plan, by its fully qualified name.
struct ManagedNode {
  std::string name;
  std::vector<Dependency> after;
  bool activate = true;  ///< False: it is only configured.
  bool required = true;  ///< False: if it fails, the bring-up continues without it, and no node waits for it.
};

/// The order of bring-up: dependencies first, else as listed. The same plan gives the same order, always.
///
/// Errors: a Problem that names an unknown node (with the nearest name) or the nodes of a cycle.
[[nodiscard]] Result<std::vector<ManagedNode>, Problem> bring_up_order(std::vector<ManagedNode> nodes);

/// One thing that the manager did or tried.
struct Step {
  std::string node;
  Transition transition = Transition::Configure;
  bool success = false;
  std::string
      reason;  ///< Why it was done ("bring-up", "undo: /lidar failed to configure") or, on failure, why it failed.
  MonotonicTime ended;
  Duration took{};
  bool left_out = false;  ///< It failed, and the bring-up continues without the node.
};

struct Outcome {
  bool success = false;
  Problem problem;                     ///< On failure: which step, which component, why.
  std::vector<std::string> activated;  ///< In the plan's order: that became active and stayed so, or were deactivated.
};

/// What the manager does its work with. All but `trigger` are called on the manager's thread; all but `trigger` may be empty.
struct Hooks {
  /// Threads: several at once, each for another node. Must not throw.
  std::function<TransitionOutcome(const std::string& node, Transition transition)> trigger;
  /// Where a node is. Unknown: gone. Asked on the way down only: others may have stopped it or taken it out.
  std::function<StateId(const std::string& node)> state;
  /// Why the bring-up is to end ("interrupted by SIGINT"); empty if it is not.
  std::function<std::string()> interrupted;
  std::function<void(const std::string& node, Transition transition)> on_begin;
  /// In the plan's order, whatever ended first: the same plan tells the same steps in the same order, always.
  std::function<void(const Step& step)> on_step;
  /// Once for each condition that has been waited for longer than 2 s.
  std::function<void(const std::string& node, const std::string& text)> on_wait;
};

/// Brings managed nodes up in order and down in reverse (design D8).
///
/// startup() configures all, then activates all: a device that is missing is found before anything moves. What need not wait for
/// each other goes up beside each other; what goes down does so one by one. If a step fails, no further one begins, everything
/// done so far is undone in reverse, and the outcome says what failed.
/// Threads: one caller at a time. Time: read from the clock, for timeouts and to tell how long steps took.
class LifecycleManager {
 public:
  /// `order`: what bring_up_order() has made.
  LifecycleManager(std::vector<ManagedNode> order, Hooks hooks, const Clock& clock);
  ~LifecycleManager();

  [[nodiscard]] Outcome startup(Crew& crew);
  /// The two halves of the way down, in reverse order; they go on after a failure and report the first one.
  /// `activated` holds the nodes in the order in which they were deactivated.
  [[nodiscard]] Outcome deactivate();
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
