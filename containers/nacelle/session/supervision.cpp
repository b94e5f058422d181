// SPDX-License-Identifier: Apache-2.0
#include "session/supervision.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "loading/load_request.hpp"
#include "nacelle/base/reversed.hpp"
#include "nacelle/runtime/interface_messages.hpp"

namespace nacelle::session {
namespace {

using launch::TargetState;
using runtime::message_of;

// diagnostic_aggregator reports a source as stale after 5 s without a message.
constexpr Duration kDiagnosticsPeriod = 1s;

// Where a component stood, or was going, when something went wrong there.
TargetState target_from(StateId from) {
  switch (from) {
    case StateId::Active:
    case StateId::Activating: return TargetState::Active;
    case StateId::Inactive:
    case StateId::Configuring:
    case StateId::Deactivating: return TargetState::Inactive;
    default: return TargetState::Unconfigured;
  }
}

/// The container as a row among its components, for the diagnostics.
runtime::ComponentInfo info_of_container(const runtime::Container& container, const FaultReason& fault) {
  runtime::ComponentInfo info;
  info.node = fully_qualified_node_name(container.options().name_space, container.options().name);
  info.managed = false;
  info.fault = fault;
  return info;
}

}  // namespace

Supervision::Supervision(SupervisedRun run) : run_(std::move(run)), topics_(container()) {
  container().on_fault([this](const runtime::ComponentInfo& info) {
    noted_.lock()->faults.push_back(info);
    run_.bell.ring();
  });
  container().on_state([this](const runtime::StateChange& change) {
    noted_.lock()->states.push_back(change);
    run_.bell.ring();
  });
  container().on_change([this] { run_.bell.ring(); });
}

Supervision::~Supervision() {
  container().on_fault({});
  container().on_state({});
  container().on_change({});
}

Supervision::Noted Supervision::take_noted() { return std::exchange(*noted_.lock(), {}); }

void Supervision::publish() {
  // Faults are kept for work().
  Noted noted;
  noted.states = std::exchange(noted_.lock()->states, {});
  publish(noted);
}

void Supervision::publish(const Noted& noted) {
  auto components = container().list();
  topics_.follow(components);
  for (const auto& info : components) {
    if (info.actuator) actuators_.insert(info.node);
  }
  for (const auto& change : noted.states) {
    topics_.publish(change);
    if (change.to == StateId::ErrorProcessing) before_fault_[change.node] = target_from(change.from);
    if (change.to == StateId::Active || change.from == StateId::Active) std::erase(active_order_, change.node);
    if (change.to == StateId::Active) active_order_.push_back(change.node);
  }
  next_beat_.reset();
  const std::vector<FaultTopics::Absent> absents = absent(components);
  known_.lock()->absent = absents;
  components.push_back(info_of_container(container(), known_.lock()->own_fault));
  if (topics_.publish_diagnostics(components, absents)) next_beat_ = run_.clock.now() + kDiagnosticsPeriod;
  forget_old_crashes(components);
}

std::vector<FaultTopics::Absent> Supervision::absent(const std::vector<runtime::ComponentInfo>& components) const {
  std::vector<FaultTopics::Absent> all;
  for (const auto& component : run_.left_out) {
    const std::string node = component.plan.full_name();
    if (std::ranges::find(components, node, &runtime::ComponentInfo::node) == components.end())
      all.push_back({node, component.plan.plugin, run_.crashes.reason(node)});
  }
  return all;
}

void Supervision::forget_old_crashes(const std::vector<runtime::ComponentInfo>& components) {
  const MonotonicTime now = run_.clock.now();
  for (const auto& node : run_.crashes.nodes()) {
    const auto found = std::ranges::find(components, node, &runtime::ComponentInfo::node);
    if (found == components.end() || (found->managed && found->state != StateId::Active)) {
      up_since_.erase(node);
    } else if (now - up_since_.try_emplace(node, now).first->second >= EarlyCrashes::kEarly) {
      up_since_.erase(node);
      run_.crashes.forget(node);
    }
  }
}

void Supervision::work() {
  Noted noted = take_noted();
  publish(noted);
  // Faults that stop the robot come last, so that they override a restart that another fault asks for.
  std::stable_partition(noted.faults.begin(), noted.faults.end(),
                        [this](const auto& info) { return !stops_the_robot(info); });
  for (const auto& info : noted.faults) on_fault(info);
  const std::vector<std::string> due = known_.lock()->restarts.take_due(run_.clock.now());
  for (const auto& node : due) restart(node);
}

bool Supervision::stops_the_robot(const runtime::ComponentInfo& info) const {
  return handling_of(info).stops_robot(info.actuator);
}

std::string Supervision::why_to_stop() {
  const std::vector<runtime::ComponentInfo> faults = noted_.lock()->faults;
  for (const auto& info : faults) {
    if (!info.fault.code.empty() && stops_the_robot(info))
      return fmt::format("{} is faulted ({}: {})", info.node, info.fault.code, info.fault.text);
  }
  return {};
}

std::optional<MonotonicTime> Supervision::next_due() const {
  auto next = known_.lock()->restarts.next_due();
  if (next_beat_ && (!next || *next_beat_ < *next)) next = next_beat_;
  for (const auto& [node, since] : up_since_) {
    if (const MonotonicTime due = since + EarlyCrashes::kEarly; !next || due < *next) next = due;
  }
  return next;
}

std::optional<TargetState> Supervision::target_of_restart(const std::string& node) const {
  if (const auto info = container().find(node);
      info && !info.value().fault.code.empty() &&
      handling_of(info.value()).policy_for(info.value().actuator) == FaultPolicy::RestartContainer)
    return target_before(info.value());
  const auto found = patients_.find(node);
  if (found == patients_.end() || !known_.lock()->restarts.due_of(node)) return std::nullopt;
  return found->second.target;
}

FaultHandling Supervision::handling_of(const runtime::ComponentInfo& info) const {
  const auto request = container().request_of(info.id);
  return request ? request->on_fault : FaultHandling{};
}

TargetState Supervision::target_before(const runtime::ComponentInfo& faulted) const {
  if (faulted.state == StateId::Active || faulted.state == StateId::Inactive)
    return target_from(faulted.state);  // it hangs there
  if (const auto before = before_fault_.find(faulted.node); before != before_fault_.end()) return before->second;
  const auto* const plan = run_.robot.plan().find(faulted.node);
  return plan != nullptr ? plan->target : TargetState::Active;
}

void Supervision::on_fault(const runtime::ComponentInfo& info) {
  // It may have been unloaded, or restarted by hand, since.
  const auto now = container().find(info.node);
  if (!now || now.value().fault.code.empty()) return;
  const FaultHandling handling = handling_of(now.value());
  switch (handling.policy_for(info.actuator)) {
    case FaultPolicy::Degrade: break;
    case FaultPolicy::StopRobot: stop_robot(info); break;
    // What moves was stopped when the fault was found. All components keep their states, for --resume.
    case FaultPolicy::RestartContainer:
      known_.lock()->stopped_by = info.node;
      why_to_restart_ = fmt::format("{} is faulted ({}: {}), and its policy is restart_container", info.node,
                                    info.fault.code, info.fault.text);
      break;
    case FaultPolicy::Restart: {
      Patient patient;
      if (auto request = container().request_of(now.value().id)) patient.request = std::move(*request);
      patient.request.name = info.node.substr(info.node.rfind('/') + 1);
      patient.isolated = now.value().isolated;
      patient.target = target_before(info);
      patient.handling = handling;
      plan_restart(info.node, patients_[info.node] = std::move(patient));
      break;
    }
  }
  run_.robot.composition_changed();
}

void Supervision::plan_restart(const std::string& node, const Patient& patient) {
  const bool is_due = known_.lock()->restarts.on_fault(node, patient.handling, run_.clock.now()).has_value();
  const std::uint32_t count = known_.lock()->restarts.count_of(node);
  if (is_due) {
    run_.say(fmt::format("nacelle: {} is restarted in {:g} s ({} of {})", node, to_seconds(patient.handling.backoff),
                         count, patient.handling.max_restarts));
  } else {
    run_.say(
        fmt::format("nacelle: {} stays faulted: it was restarted {} times; `nacelle faults` says why", node, count));
  }
}

Result<runtime::ComponentInfo, Problem> Supervision::load_again(const std::string& node, const Patient& patient) {
  const auto* const plan = run_.robot.plan().find(node);
  if (!patient.isolated || plan == nullptr) return container().load(patient.request);
  launch::ComponentPlan component = *plan;
  component.parameters = loading::parameters_of(patient.request);
  return run_.robot.load(component);
}

void Supervision::restart(const std::string& node) {
  const auto found = patients_.find(node);
  if (found == patients_.end()) return;
  Patient& patient = found->second;
  if (const auto now = container().find(node)) {
    if (now.value().fault.code.empty()) return;  // it was handled by another caller meanwhile
    // One that hangs stays where it is, with its thread and library; its name becomes free.
    static_cast<void>(container().unload(now.value().id));
  } else if (!patient.gone) {  // a person has taken it out meanwhile
    known_.lock()->restarts.forget(node);
    patients_.erase(found);
    return;
  }
  auto loaded = load_again(node, patient);
  Result<void, Problem> done{};
  patient.gone = !loaded;
  if (!loaded) {
    done = err(loaded.error());
  } else if (loaded.value().managed) {
    done = run_.robot.bring_to(loaded.value(), patient.target);
  }
  if (done) {
    run_.say(fmt::format("nacelle: {} was restarted ({} of {})", node, known_.lock()->restarts.count_of(node),
                         patient.handling.max_restarts));
  } else {
    run_.say("nacelle: the restart failed: " + done.error().text());
    plan_restart(node, patient);
  }
  run_.robot.composition_changed();
}

// Deactivates actuators first, though they are in the middle of the order: a stop frame written from outside holds only until the
// next command of a base that is still active.
void Supervision::stop_robot(const runtime::ComponentInfo& cause) {
  container().stop_what_moves();
  // No component restarts by itself.
  known_.lock()->restarts = {};
  patients_.clear();
  std::vector<runtime::ComponentInfo> order = container().list();
  std::erase_if(order, [](const auto& info) { return !info.managed || info.state != StateId::Active; });
  // In reverse order of activation.
  const auto place = [this](const auto& info) {
    return std::ranges::find(active_order_, info.node) - active_order_.begin();
  };
  std::ranges::reverse(order);
  std::ranges::stable_sort(order, [&](const auto& a, const auto& b) { return place(a) > place(b); });
  std::stable_partition(order.begin(), order.end(), [](const auto& info) { return info.actuator; });
  std::string failed;
  for (const auto& info : order) {
    const auto outcome = container().trigger(info.id, Transition::Deactivate);
    if (!outcome.success) failed += fmt::format("; {} could not deactivate: {}", info.node, outcome.reason);
  }
  container().write_safe_stops();
  known_.lock()->stopped_by = cause.node;
  run_.say(fmt::format("nacelle: the robot is stopped: {} is faulted ({}: {}), {} components deactivated{}", cause.node,
                       cause.fault.code, cause.fault.text, order.size(), failed));
}

void Supervision::set_own_fault(const FaultReason& fault) {
  known_.lock()->own_fault = fault;
  publish();
}

nacelle_interfaces::srv::GetFaults::Response Supervision::report() const {
  const Known known = *known_.lock();
  const auto events = container().faults();
  const auto components = container().list();
  nacelle_interfaces::srv::GetFaults::Response answer;
  if (!known.own_fault.code.empty()) answer.container_fault.push_back(message_of(known.own_fault));
  for (const auto& info : components) {
    const FaultHandling handling = handling_of(info);
    const auto restarts = known.restarts.count_of(info.node);
    if (info.fault.code.empty() && info.open_faults.empty() && restarts == 0) continue;
    auto& row = answer.components.emplace_back();
    row.node = info.node;
    if (info.managed) row.state = nacelle::to_text(info.state);
    if (!info.fault.code.empty()) row.fault.push_back(message_of(info.fault));
    for (const auto& fault : info.open_faults) row.open_faults.push_back(message_of(fault));
    row.policy = to_text(handling.policy_for(info.actuator));
    row.restarts = restarts;
    row.max_restarts = handling.max_restarts;
    if (const auto due = known.restarts.due_of(info.node))
      row.next_restart_s.push_back(std::max(0.0, to_seconds(*due - run_.clock.now())));
    const auto last = std::ranges::find(events.rbegin(), events.rend(), info.node, &runtime::FaultEvent::node);
    if (last != events.rend()) row.last.push_back(message_of(*last));
  }
  for (const auto& event : events) answer.history.push_back(message_of(event));
  for (const auto& absent : known.absent) {
    // It may have been loaded since.
    if (std::ranges::find(components, absent.node, &runtime::ComponentInfo::node) != components.end()) continue;
    auto& row = answer.left_out.emplace_back();
    row.node = absent.node;
    row.plugin = absent.plugin;
    row.why = absent.why;
  }
  answer.robot_stopped_by = known.stopped_by;
  return answer;
}

}  // namespace nacelle::session
