// SPDX-License-Identifier: Apache-2.0
// How a session's robot goes up: load, prove, start programs, configure and activate.
#include <fmt/format.h>

#include <algorithm>

#include "isolation/carriers.hpp"
#include "isolation/isolated_component.hpp"
#include "loading/load_request.hpp"
#include "nacelle/base/lifecycle_fault.hpp"
#include "requests/request_server.hpp"
#include "session/bring_up_fault.hpp"
#include "session/readiness.hpp"
#include "session/session.hpp"

namespace nacelle::session {
namespace {

constexpr Duration kProgramReadyLimit = 15s;

Problem interrupted(const process::StopSignal& stop) {
  return {"bring-up", fmt::format("interrupted by {}", stop.name()), "everything started so far was rolled back",
          LifecycleFault::Interrupted, stop.name()};
}

/// "/lidar (DEVICE_LOST: ...), /imu (...)"
std::string open_faults_of(const std::vector<runtime::ComponentInfo>& components) {
  std::vector<std::string> rows;
  for (const auto& info : components) {
    for (const auto& fault : info.open_faults)
      rows.push_back(fmt::format("{} ({}: {})", info.node, fault.code, fault.text));
  }
  return join(rows);
}

}  // namespace

Result<void, Problem> Session::bring_up() {
  // Making a component touches no hardware: programs that stand for it are not needed before the plan is known to be sound.
  if (auto loaded = load_components(); !loaded) return loaded;
  if (auto sound = check_the_plan(); !sound) return sound;
  if (auto started = start_programs(); !started) return started;
  return activate();
}

Result<void, Problem> Session::check_the_plan() {
  const auto findings = proof::prove(plan_, options_.places, *container_, loaded_);
  loaded_.clear();
  for (const auto& finding : findings) say("nacelle: " + finding.text());
  // After a crash, everything that can be restored is, even if a part had been unloaded before.
  if (proof::has_errors(findings) && !is_resumed_) {
    return err(Problem{"the plan is unsound", proof::summary(findings),
                       "nothing was started; `nacelle check` tells the same without a robot", BringUpFault::UnsoundPlan,
                       proof::summary(findings)});
  }
  budgets_ = runtime::BudgetWatch{proof::stream_budgets(plan_, *container_)};
  return {};
}

Result<void, Problem> Session::start_programs() {
  for (const auto& plan : plan_.programs) {
    if (stop_.is_raised()) return err(interrupted(stop_));
    auto spec = loading::program_spec_of(plan, options_.places.program, options_.places.prefixes);
    if (!spec) return err(spec.error());
    progress("starting program " + spec.value().label);
    auto program = process::ForeignProgram::start(spec.value());
    if (!program)
      return err(Problem{plan.where, program.error().where.text() + ": " + program.error().what,
                         program.error().way_out, program.error().code, program.error().value});
    programs_.push_back(std::move(program).value());
    if (auto ready = programs_.back()->wait_until_ready(kProgramReadyLimit, stop_.descriptor(), clock_); !ready)
      return ready;
  }
  return {};
}

Result<runtime::ComponentInfo, Problem> Session::load(const launch::ComponentPlan& component,
                                                      const std::shared_ptr<ParameterFaults>& faults) {
  if (component.isolate == launch::Isolation::None) {
    runtime::LoadRequest request = loading::load_request_of(component);
    request.faults = faults;
    return container_->load(request);
  }
  auto started = isolation::IsolatedComponent::start(component, options_.places, *container_, carrier_.get(), clock_,
                                                     faults.get());
  if (!started) return err(started.error());
  auto adopted = container_->adopt(started.value());
  if (adopted) {
    adopted.value().warnings = started.value()->info().warnings;
    adopted.value().declared = started.value()->info().declared;
  } else {
    started.value()->unload();
  }
  return adopted;
}

void Session::start_the_carrier() {
  const auto is_apart = [](const auto& component) { return component.isolate == launch::Isolation::Process; };
  if (options_.carrier.empty() || std::ranges::none_of(plan_.components, is_apart)) return;
  auto started = isolation::start_carrier(options_.carrier);
  if (started) {
    carrier_ = std::move(started).value();
  } else {
    say("nacelle: streams between processes go over a socket: " + started.error().text());
  }
}

Result<void, Problem> Session::load_components() {
  start_the_carrier();
  std::size_t number = 0;
  for (const auto& component : plan_.components) {
    if (stop_.is_raised()) return err(interrupted(stop_));
    progress(fmt::format("[{}/{}] loading {}", ++number, plan_.components.size(), component.full_name()));
    const auto faults = std::make_shared<ParameterFaults>();
    auto loaded = load(component, faults);
    auto& entry = loaded_.emplace_back();
    entry.plan = &component;
    entry.faults = *faults->lock();
    if (loaded) {
      entry.declared = loaded.value().declared;
      // Those of a component in this process have been logged.
      if (component.isolate == launch::Isolation::Process)
        for (const auto& line : loaded.value().warnings) say("nacelle: " + line);
    } else {
      entry.failure = loaded.error();
    }
    if (!component.required && (entry.failure || has_errors(entry.faults))) {
      if (loaded) static_cast<void>(container_->unload(loaded.value().id));
      say("nacelle: left out, since it is not required: " + component.full_name());
    }
    composition_changed();
    answer_guests();
  }
  return {};
}

Result<void, Problem> Session::activate() {
  std::vector<lifecycle_manager::ManagedNode> nodes;
  const auto takes_part = [this](const std::string& name) {
    const auto* const component = plan_of(name);
    const auto found = container_->find(name);
    return component != nullptr && found && found.value().managed &&
           component->target != launch::TargetState::Unconfigured;
  };
  for (const auto& component : plan_.components) {
    if (component.required && !container_->find(component.full_name()))
      return err(Problem{component.where, component.full_name() + " was not loaded", "see above",
                         BringUpFault::NotLoaded, component.full_name()});
    if (!takes_part(component.full_name())) continue;
    lifecycle_manager::ManagedNode node{
        component.full_name(), {}, component.target == launch::TargetState::Active, component.required};
    for (const auto& after : component.after) {
      // A component that was left out, or that has no state to wait for, delays no other.
      if (!takes_part(after.node)) continue;
      node.after.push_back({after.node, after.where, words_of(after), missing_of(after, *container_),
                            after.timeout.value_or(lifecycle_manager::kReadinessLimit)});
    }
    nodes.push_back(std::move(node));
  }
  auto order = lifecycle_manager::bring_up_order(std::move(nodes));
  if (!order) return err(order.error());
  lifecycle_manager::Hooks hooks;
  hooks.trigger = [this](const std::string& node, Transition transition) { return trigger(node, transition); };
  hooks.state = [this](const std::string& node) {
    const auto found = container_->find(node);
    return found ? found.value().state : StateId::Unknown;
  };
  hooks.interrupted = [this] { return why_not_go_up(); };
  hooks.on_begin = [this](const std::string& node, Transition transition) {
    progress(fmt::format("{} {}", nacelle::to_text(transition), node));
  };
  hooks.on_step = [this](const lifecycle_manager::Step& step) { on_step(step); };
  hooks.on_wait = [this](const std::string& node, const std::string& text) {
    say(fmt::format("nacelle: {} {}", node, text));
  };
  manager_ = std::make_unique<lifecycle_manager::LifecycleManager>(std::move(order).value(), std::move(hooks), clock_);
  const auto outcome = [this] {
    lifecycle_manager::ThreadCrew crew;
    return manager_->startup(crew);
  }();
  if (outcome.success) {
    report_.bringup = process::time_since_process_start();
    service_->set_phase(Phase::Running);
    composition_changed();
    std::string names;
    for (const auto& name : report_.bringup_order) names += " " + name;
    const std::size_t count = report_.bringup_order.size();
    say(fmt::format("{} component{} active in {:.0f} ms{}{}", count, count == 1 ? "" : "s",
                    to_milliseconds(report_.bringup), count == 0 ? "" : ":", names));
    if (const std::string network = network_->line(); !network.empty()) say(network);
    say_what_rests();
    if (const std::string open = open_faults_of(container_->list()); !open.empty())
      say("nacelle: absent devices: " + open +
          "; each component connects by itself when its device appears, see `nacelle faults`");
    return {};
  }
  if (stop_.is_raised()) return err(interrupted(stop_));
  const auto* const component = plan_of(outcome.problem.where.node);
  Problem problem = outcome.problem;
  if (component != nullptr) {
    problem.where = component->where;
    problem.what = "component " + component->name + " (" + component->plugin + "): " + problem.what;
  }
  return err(problem);
}

std::string Session::why_not_go_up() {
  if (service_->phase() != Phase::Starting) return {};
  answer_guests();
  std::string why = stop_.is_raised() ? fmt::format("interrupted by {}", stop_.name()) : supervision_->why_to_stop();
  if (!why.empty()) {
    container_->stop_what_moves();
    container_->give_up_transitions_after(kShutdownStepLimit);
  }
  return why;
}

// On a thread of the crew, for several components at once.
TransitionOutcome Session::trigger(const std::string& node, Transition transition) {
  const auto found = container_->find(node);
  if (!found) return {false, StateId::Unknown, "it is not loaded any more"};
  return container_->trigger(found.value().id, transition);
}

void Session::log_transition(const lifecycle_manager::Step& step) {
  const auto logged = transitions_->add(step);
  if (logged) return;
  say("nacelle: " + logged.error().text());
  transitions_.reset();  // reported once
}

void Session::on_step(const lifecycle_manager::Step& step) {
  const std::string name = report::component_name(step.node);
  if (step.success && step.transition == Transition::Activate) report_.bringup_order.push_back(name);
  if (step.success && step.transition == Transition::Deactivate) report_.shutdown_order.push_back(name);
  if (step.left_out)
    say(fmt::format("nacelle: left out, since it is not required: {} could not {}: {}", step.node,
                    nacelle::to_text(step.transition), step.reason));
  service_->set_nodes(container_->list());
  if (transitions_) log_transition(step);
  if (options_.verbose)
    progress(fmt::format("{} {} {} in {:.1f} ms ({})", step.node, nacelle::to_text(step.transition),
                         step.success ? "done" : "FAILED", to_milliseconds(step.took), step.reason));
}

}  // namespace nacelle::session
