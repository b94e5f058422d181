// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/node/lifecycle_node.hpp"

namespace nacelle::lifecycle_manager {

/// A node that must be active before another one is activated.
struct Dependency {
  std::string node;
  std::string where;  ///< file:line of the plan, for messages.
};

/// One node of the plan, by its fully qualified name.
struct ManagedNode {
  std::string name;
  std::vector<Dependency> after;
};

/// The order of bring-up: dependencies first, else as listed. The same plan gives the same order, always.
///
/// Errors: a Problem that names an unknown node (with the nearest name) or the nodes of a cycle.
[[nodiscard]] Result<std::vector<std::string>, Problem> bring_up_order(const std::vector<ManagedNode>& nodes);

/// One thing that the manager did or tried.
struct Step {
  std::string node;
  Transition transition = Transition::Configure;
  bool success = false;
  std::string
      reason;  ///< Why it was done ("bring-up", "undo: /lidar failed to configure") or, on failure, why it failed.
  Duration took{};
};

struct Outcome {
  bool success = false;
  Problem problem;                     ///< On failure: which step, which component, why.
  std::vector<std::string> activated;  ///< In the order in which they became active and stayed so.
};

/// Brings managed nodes up in order and down in reverse (design D8).
///
/// startup() configures all in order, then activates all in order: a device that is missing is found before anything moves.
/// If a step fails, everything done so far is undone in reverse, and the outcome says what failed.
/// Threads: one caller at a time. Time: read from the clock only to tell how long steps took.
class LifecycleManager {
 public:
  using Trigger = std::function<TransitionOutcome(const std::string& node, Transition transition)>;
  using OnStep = std::function<void(const Step& step)>;

  LifecycleManager(std::vector<std::string> order, Trigger trigger, const Clock& clock, OnStep on_step = {});

  [[nodiscard]] Outcome startup();
  /// Deactivates, then cleans up, in reverse order; goes on after a failure and reports the first one.
  /// `activated` holds the nodes in the order in which they were deactivated.
  [[nodiscard]] Outcome shutdown();

 private:
  enum class Level { Unconfigured, Inactive, Active };
  struct Entry {
    std::string name;
    Level level = Level::Unconfigured;
  };
  TransitionOutcome step(Entry& entry, Transition transition, const std::string& why);
  void undo(const std::string& why);

  std::vector<Entry> entries_;
  Trigger trigger_;
  const Clock& clock_;
  OnStep on_step_;
};

}  // namespace nacelle::lifecycle_manager
