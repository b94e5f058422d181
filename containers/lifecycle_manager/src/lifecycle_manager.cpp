// SPDX-License-Identifier: Apache-2.0
#include "nacelle/lifecycle_manager/lifecycle_manager.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/reversed.hpp"

namespace nacelle::lifecycle_manager {
namespace {

constexpr Duration kStuckAfter = 3s;      // a driver may wait two for its device
constexpr Duration kLookPeriod = 10ms;    // of conditions, which have no notification
constexpr Duration kNoticePeriod = 50ms;  // at steps that take long, and so that Hooks::interrupted is asked as often

enum class Level { Unconfigured, Inactive, Active };

Level level_of(StateId state) {
  return state == StateId::Active ? Level::Active : state == StateId::Inactive ? Level::Inactive : Level::Unconfigured;
}

std::string words_of(const Dependency& dependency) {
  return dependency.beside.empty() ? dependency.node : dependency.beside + " of " + dependency.node;
}

}  // namespace

struct LifecycleManager::Entry {
  explicit Entry(ManagedNode given) : node(std::move(given)), waits(node.after.size()) {}

  struct Wait {
    std::optional<MonotonicTime> since;  // the other node is active, and the condition does not hold yet
    bool told = false;
  };

  ManagedNode node;
  Level level = Level::Unconfigured;
  bool left_out = false;
  std::vector<Wait> waits;  // beside node.after

  // The step of this phase.
  enum class Phase { Waiting, UnderWay, Over } phase = Phase::Waiting;
  bool was_slow = false;
  MonotonicTime began, ended;
  std::atomic<bool> has_ended{false};  // release: `outcome` and `ended` are there
  TransitionOutcome outcome;
  std::optional<Step> step;  // to be reported
};

LifecycleManager::LifecycleManager(std::vector<ManagedNode> order, Hooks hooks, const Clock& clock)
    : hooks_(std::move(hooks)), clock_(clock) {
  for (auto& node : order) entries_.emplace_back(std::move(node));
}

LifecycleManager::~LifecycleManager() = default;

LifecycleManager::Entry* LifecycleManager::find(const std::string& name) {
  const auto found = std::ranges::find(entries_, name, [](const Entry& entry) { return entry.node.name; });
  return found == entries_.end() ? nullptr : &*found;
}

void LifecycleManager::begin(Entry& entry, Transition transition, Crew& crew) {
  entry.phase = Entry::Phase::UnderWay;
  entry.began = clock_.now();
  if (hooks_.on_begin) hooks_.on_begin(entry.node.name, transition);
  crew.start([this, &entry, transition] {
    entry.outcome = hooks_.trigger(entry.node.name, transition);
    entry.ended = clock_.now();
    entry.has_ended.store(true, std::memory_order_release);
  });
}

void LifecycleManager::tell(Entry& entry) {
  if (!entry.step) return;
  if (hooks_.on_step) hooks_.on_step(*entry.step);
  entry.step.reset();
}

std::size_t LifecycleManager::collect(Transition transition, bool goes_on) {
  std::size_t under_way = 0;
  bool all_before_are_over = true;
  for (auto& entry : entries_) {
    if (entry.phase == Entry::Phase::UnderWay && entry.has_ended.load(std::memory_order_acquire)) {
      entry.phase = Entry::Phase::Over;
      // The node's reported state counts, not the requested one: an error leaves it unconfigured.
      entry.level = level_of(entry.outcome.state);
      const bool success = entry.outcome.success;
      entry.left_out = !success && !entry.node.required;
      entry.step = Step{
          entry.node.name,           transition,    success, success ? "bring-up" : entry.outcome.reason, entry.ended,
          entry.ended - entry.began, entry.left_out};
    }
    if (entry.phase == Entry::Phase::UnderWay) {
      ++under_way;
      if (goes_on && !entry.was_slow && clock_.now() - entry.began >= kStuckAfter) {
        entry.was_slow = true;
        if (hooks_.on_wait) hooks_.on_wait(entry.node.name, fmt::format("is still in on_{}", to_text(transition)));
      }
    }
    all_before_are_over = all_before_are_over && entry.phase == Entry::Phase::Over;
    if (all_before_are_over) tell(entry);
  }
  return under_way;
}

LifecycleManager::Readiness LifecycleManager::readiness(Entry& entry) {
  bool ready = true;
  const MonotonicTime now = clock_.now();
  for (std::size_t i = 0; i < entry.waits.size(); ++i) {
    const Dependency& dependency = entry.node.after[i];
    Entry::Wait& wait = entry.waits[i];
    const Entry* const other = find(dependency.node);
    // A node that was left out, or that will not be activated, delays no other.
    if (other == nullptr || other->left_out || !other->node.activate) continue;
    std::string lacking;
    if (other->level != Level::Active) {
      lacking = "it is not active yet";
    } else if (dependency.missing) {
      if (!wait.since) wait.since = now;
      lacking = dependency.missing();
    }
    if (lacking.empty()) continue;
    ready = false;
    const Duration waited = now - wait.since.value_or(phase_begin_);
    if (!wait.told && waited >= kStuckAfter) {
      wait.told = true;
      if (hooks_.on_wait) {
        const std::string limit =
            wait.since ? fmt::format(" (at most {:.3g} s)", to_seconds(dependency.timeout)) : std::string{};
        hooks_.on_wait(entry.node.name, fmt::format("waits for {}: {}{}", words_of(dependency), lacking, limit));
      }
    }
    if (wait.since && waited >= dependency.timeout) {
      entry.outcome = {false, StateId::Inactive,
                       fmt::format("{}: waited {:.3g} s for {}: {}", dependency.where.text(),
                                   to_seconds(dependency.timeout), words_of(dependency), lacking)};
      return Readiness::Never;
    }
  }
  return ready ? Readiness::Ready : Readiness::NotYet;
}

void LifecycleManager::run_phase(Transition transition, Crew& crew, Outcome& result) {
  phase_begin_ = clock_.now();
  const bool up = transition == Transition::Activate;
  for (auto& entry : entries_) {
    const bool has_a_step = !up || (entry.node.activate && entry.level == Level::Inactive);
    entry.phase = has_a_step ? Entry::Phase::Waiting : Entry::Phase::Over;
    entry.has_ended.store(false, std::memory_order_relaxed);
    entry.was_slow = false;
    entry.outcome = {true, StateId::Unknown, {}};
  }
  std::string interrupted;
  bool goes_on = true;
  while (true) {
    const std::size_t under_way = collect(transition, goes_on);
    if (interrupted.empty() && hooks_.interrupted) interrupted = hooks_.interrupted();
    goes_on = interrupted.empty() && std::ranges::none_of(entries_, [](const Entry& entry) {
                return entry.phase == Entry::Phase::Over && !entry.outcome.success && !entry.left_out;
              });
    bool began = false, waiting = false;
    for (auto& entry : entries_) {
      if (!goes_on || entry.phase != Entry::Phase::Waiting) continue;
      switch (up ? readiness(entry) : Readiness::Ready) {
        case Readiness::NotYet: waiting = true; break;
        case Readiness::Ready:
          begin(entry, transition, crew);
          began = true;
          break;
        case Readiness::Never:
          entry.phase = Entry::Phase::UnderWay;  // collect() takes it as a step that failed at once
          entry.began = entry.ended = clock_.now();
          entry.has_ended.store(true, std::memory_order_release);
          began = true;
          break;
      }
    }
    if (began) continue;
    if (under_way == 0 && !waiting) break;
    crew.wait(waiting ? kLookPeriod : kNoticePeriod);
  }
  for (auto& entry : entries_) tell(entry);
  for (auto& entry : reversed(entries_)) {
    if (entry.left_out && entry.level == Level::Inactive) step_down(entry, Transition::Cleanup, "left out");
  }
  for (const auto& entry : entries_) {
    if (entry.outcome.success || entry.left_out) continue;
    result.problem = {Place::of_node(entry.node.name),
                      std::string("could not ") + to_text(transition) + ": " + entry.outcome.reason,
                      "nothing was left running: everything started so far was rolled back",
                      LifecycleFault::TransitionFailed, to_text(transition)};
    return;
  }
  if (!interrupted.empty())
    result.problem = {"bring-up", interrupted, "nothing was left running: everything started so far was rolled back",
                      LifecycleFault::Interrupted};
}

TransitionOutcome LifecycleManager::step_down(Entry& entry, Transition transition, const std::string& why) {
  const MonotonicTime begin = clock_.now();
  if (hooks_.on_begin) hooks_.on_begin(entry.node.name, transition);
  TransitionOutcome outcome = hooks_.trigger(entry.node.name, transition);
  entry.level = level_of(outcome.state);  // a failed deactivation leaves it active
  const MonotonicTime end = clock_.now();
  if (hooks_.on_step)
    hooks_.on_step(
        {entry.node.name, transition, outcome.success, outcome.success ? why : outcome.reason, end, end - begin});
  return outcome;
}

void LifecycleManager::undo(const std::string& why) {
  for (auto& entry : reversed(entries_)) {
    if (entry.level == Level::Active) step_down(entry, Transition::Deactivate, why);
  }
  for (auto& entry : reversed(entries_)) {
    if (entry.level == Level::Inactive) step_down(entry, Transition::Cleanup, why);
  }
}

Outcome LifecycleManager::startup(Crew& crew) {
  Outcome result;
  for (const Transition transition : {Transition::Configure, Transition::Activate}) {
    run_phase(transition, crew, result);
    if (result.problem.where.empty()) continue;
    undo("undo: " + result.problem.where.text() + " could not " + to_text(transition));
    return result;
  }
  for (const auto& entry : entries_) {
    if (entry.level == Level::Active) result.activated.push_back(entry.node.name);
  }
  result.success = true;
  return result;
}

Outcome LifecycleManager::take_down(Transition transition) {
  Outcome result;
  result.success = true;
  for (auto& entry : reversed(entries_)) {
    // Others may have stopped it (a fault, a person), brought it back, or taken it out.
    if (hooks_.state) entry.level = level_of(hooks_.state(entry.node.name));
    if (entry.level != (transition == Transition::Deactivate ? Level::Active : Level::Inactive)) continue;
    const TransitionOutcome outcome = step_down(entry, transition, "shutdown");
    if (outcome.success) {
      result.activated.push_back(entry.node.name);
    } else if (result.success) {
      result.success = false;
      result.problem = {Place::of_node(entry.node.name),
                        std::string("could not ") + to_text(transition) + ": " + outcome.reason, "",
                        LifecycleFault::TransitionFailed, to_text(transition)};
    }
  }
  return result;
}

Outcome LifecycleManager::deactivate() { return take_down(Transition::Deactivate); }
Outcome LifecycleManager::cleanup() { return take_down(Transition::Cleanup); }

}  // namespace nacelle::lifecycle_manager
