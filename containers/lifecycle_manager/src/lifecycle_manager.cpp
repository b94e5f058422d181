// SPDX-License-Identifier: Apache-2.0
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"

#include <algorithm>
#include <ranges>

namespace nacelle::lifecycle_manager {
namespace {

enum class Mark { New, Open, Done };

// Depth-first along `after`; an open node met again closes a cycle.
struct Sorter {
  const std::vector<ManagedNode>& nodes;
  std::vector<Mark> marks = std::vector<Mark>(nodes.size(), Mark::New);
  std::vector<std::string> order, path;

  [[nodiscard]] std::ptrdiff_t index_of(const std::string& name) const {
    const auto found = std::ranges::find(nodes, name, &ManagedNode::name);
    return found == nodes.end() ? -1 : found - nodes.begin();
  }

  Result<void, Problem> visit(std::size_t i) {
    if (marks[i] == Mark::Done) return {};
    if (marks[i] == Mark::Open) {
      std::vector<std::string> cycle(std::ranges::find(path, nodes[i].name), path.end());
      cycle.push_back(nodes[i].name);
      return err(Problem{nodes[i].after.front().where, "these nodes wait for each other: " + join(cycle, " -> "),
                         "remove one of their after: entries"});
    }
    marks[i] = Mark::Open;
    path.push_back(nodes[i].name);
    for (const auto& dependency : nodes[i].after) {
      const auto j = index_of(dependency.node);
      if (j < 0) {
        std::vector<std::string> names;
        for (const auto& node : nodes) names.push_back(node.name);
        return err(Problem{dependency.where,
                           nodes[i].name + " is after '" + dependency.node + "', which is not in the plan",
                           suggestion(dependency.node, names)});
      }
      if (auto ok = visit(static_cast<std::size_t>(j)); !ok) return ok;
    }
    path.pop_back();
    marks[i] = Mark::Done;
    order.push_back(nodes[i].name);
    return {};
  }
};

}  // namespace

Result<std::vector<std::string>, Problem> bring_up_order(const std::vector<ManagedNode>& nodes) {
  Sorter sorter{nodes};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (auto ok = sorter.visit(i); !ok) return err(ok.error());
  }
  return std::move(sorter.order);
}

LifecycleManager::LifecycleManager(std::vector<std::string> order, Trigger trigger, const Clock& clock, OnStep on_step)
    : trigger_(std::move(trigger)), clock_(clock), on_step_(std::move(on_step)) {
  for (auto& name : order) entries_.push_back({std::move(name)});
}

TransitionOutcome LifecycleManager::step(Entry& entry, Transition transition, const std::string& why) {
  const MonotonicTime begin = clock_.now();
  TransitionOutcome outcome = trigger_(entry.name, transition);
  // The node's own word counts, not what was asked for: a failed deactivation leaves it active, an error unconfigured.
  if (outcome.state == StateId::Active)
    entry.level = Level::Active;
  else if (outcome.state == StateId::Inactive)
    entry.level = Level::Inactive;
  else
    entry.level = Level::Unconfigured;
  if (on_step_)
    on_step_({entry.name, transition, outcome.success, outcome.success ? why : outcome.reason, clock_.now() - begin});
  return outcome;
}

void LifecycleManager::undo(const std::string& why) {
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (entry->level == Level::Active) step(*entry, Transition::Deactivate, why);
  }
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (entry->level == Level::Inactive) step(*entry, Transition::Cleanup, why);
  }
}

Outcome LifecycleManager::startup() {
  Outcome result;
  for (const Transition transition : {Transition::Configure, Transition::Activate}) {
    for (auto& entry : entries_) {
      const TransitionOutcome outcome = step(entry, transition, "bring-up");
      if (outcome.success) {
        if (transition == Transition::Activate) result.activated.push_back(entry.name);
        continue;
      }
      result.problem = {entry.name, std::string("could not ") + to_text(transition) + ": " + outcome.reason,
                        "nothing was left running: what had been started is undone"};
      result.activated.clear();
      undo("undo: " + entry.name + " could not " + to_text(transition));
      return result;
    }
  }
  result.success = true;
  return result;
}

Outcome LifecycleManager::shutdown() {
  Outcome result;
  result.success = true;
  const auto take = [&](Level level, Transition transition) {
    for (auto at = entries_.rbegin(); at != entries_.rend(); ++at) {
      Entry& entry = *at;
      if (entry.level != level) continue;
      const TransitionOutcome outcome = step(entry, transition, "shutdown");
      if (outcome.success) {
        if (transition == Transition::Deactivate) result.activated.push_back(entry.name);
      } else if (result.success) {
        result.success = false;
        result.problem = {entry.name, std::string("could not ") + to_text(transition) + ": " + outcome.reason, ""};
      }
    }
  };
  take(Level::Active, Transition::Deactivate);
  take(Level::Inactive, Transition::Cleanup);
  return result;
}

}  // namespace nacelle::lifecycle_manager
