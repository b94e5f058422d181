// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/supervision.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nacelle/base/reversed.hpp"
#include "nacelle/session/load_request.hpp"
#include "nacelle/session/session.hpp"

namespace nacelle::session {
namespace {

using launch::TargetState;
using nlohmann::json;
using runtime::FaultPolicy;

// Who reads diagnostics takes a silent source for a dead one after a few seconds. Source: diagnostic_aggregator, 5 s.
constexpr Duration kDiagnosticsPeriod = 1s;

void wake(int event) {
  const std::uint64_t one = 1;
  static_cast<void>(!::write(event, &one, sizeof one));
}

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

json to_json(const runtime::FaultEvent& event) {
  json row{{"number", event.number}, {"node", event.node},         {"code", event.code},
           {"text", event.text},     {"callback", event.callback}, {"time_ns", event.when.nanoseconds()}};
  if (event.is_open_fault) row["open"] = !event.lasted;
  if (event.lasted) row["lasted_s"] = to_seconds(*event.lasted);
  return row;
}

}  // namespace

Supervision::Supervision(Session& session, const Clock& clock, int event)
    : session_(session), clock_(clock), topics_(session.container()) {
  session.container().on_fault([this, event](const runtime::ComponentInfo& info) {
    noted_.lock()->faults.push_back(info);
    wake(event);
  });
  session.container().on_state([this, event](const runtime::StateChange& change) {
    noted_.lock()->states.push_back(change);
    wake(event);
  });
  session.container().on_change([event] { wake(event); });
}

Supervision::~Supervision() {
  session_.container().on_fault({});
  session_.container().on_state({});
  session_.container().on_change({});
}

Supervision::Noted Supervision::take_noted() { return std::exchange(*noted_.lock(), {}); }

void Supervision::publish() {
  // Faults are kept for work().
  Noted noted;
  noted.states = std::exchange(noted_.lock()->states, {});
  publish(noted);
}

void Supervision::publish(const Noted& noted) {
  const auto components = session_.container().list();
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
  if (topics_.publish_diagnostics(components)) next_beat_ = clock_.now() + kDiagnosticsPeriod;
}

void Supervision::work() {
  Noted noted = take_noted();
  publish(noted);
  // Who stops the robot has the last word, also over a restart that another fault asks for.
  std::stable_partition(noted.faults.begin(), noted.faults.end(),
                        [this](const auto& info) { return !stops_the_robot(info); });
  for (const auto& info : noted.faults) on_fault(info);
  for (const auto& node : restarts_.take_due(clock_.now())) restart(node);
}

bool Supervision::stops_the_robot(const runtime::ComponentInfo& info) const {
  return handling_of(info).policy_for(info.actuator) == FaultPolicy::StopRobot;
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
  auto next = restarts_.next_due();
  if (next_beat_ && (!next || *next_beat_ < *next)) next = next_beat_;
  return next;
}

std::optional<TargetState> Supervision::target_of_restart(const std::string& node) const {
  const auto found = patients_.find(node);
  if (found == patients_.end() || !restarts_.due_of(node)) return std::nullopt;
  return found->second.target;
}

runtime::FaultHandling Supervision::handling_of(const runtime::ComponentInfo& info) const {
  if (auto request = session_.container().request_of(info.id)) return request->on_fault;
  // Of another process: what the launch file says.
  const auto* const plan = session_.plan().find(info.node);
  return plan != nullptr ? load_request_of(*plan).on_fault : runtime::FaultHandling{};
}

void Supervision::on_fault(const runtime::ComponentInfo& info) {
  // It may have been unloaded, or mended by hand, since.
  const auto now = session_.container().find(info.node);
  if (!now || now.value().fault.code.empty()) return;
  const runtime::FaultHandling handling = handling_of(now.value());
  switch (handling.policy_for(info.actuator)) {
    case FaultPolicy::Degrade: break;
    case FaultPolicy::StopRobot: stop_robot(info); break;
    case FaultPolicy::Restart: {
      Patient patient;
      if (auto request = session_.container().request_of(now.value().id)) {
        patient.request = std::move(*request);
        patient.request.name = info.node.substr(info.node.rfind('/') + 1);
      } else {
        patient.apart = true;
      }
      const auto before = before_fault_.find(info.node);
      const auto* const plan = session_.plan().find(info.node);
      if (info.state == StateId::Active || info.state == StateId::Inactive) {
        patient.target = target_from(info.state);  // it hangs there
      } else if (before != before_fault_.end()) {
        patient.target = before->second;
      } else if (plan != nullptr) {
        patient.target = plan->target;
      }
      patient.handling = handling;
      plan_restart(info.node, patients_[info.node] = std::move(patient));
      break;
    }
  }
  session_.composition_changed();
}

void Supervision::plan_restart(const std::string& node, const Patient& patient) {
  if (restarts_.on_fault(node, patient.handling, clock_.now())) {
    session_.say(fmt::format("nacelle: {} is restarted in {:g} s ({} of {})", node,
                             to_seconds(patient.handling.backoff), restarts_.count_of(node),
                             patient.handling.max_restarts));
  } else {
    session_.say(fmt::format("nacelle: {} stays faulted: it was restarted {} times; `nacelle faults` says why", node,
                             restarts_.count_of(node)));
  }
}

void Supervision::restart(const std::string& node) {
  const auto found = patients_.find(node);
  if (found == patients_.end()) return;
  Patient& patient = found->second;
  if (const auto now = session_.container().find(node)) {
    if (now.value().fault.code.empty()) return;  // somebody was faster
    // One that hangs stays where it is, with its thread and library; its name becomes free.
    static_cast<void>(session_.container().unload(now.value().id));
  } else if (!patient.gone) {  // a person has taken it out meanwhile
    restarts_.forget(node);
    patients_.erase(found);
    return;
  }
  const auto* const plan = session_.plan().find(node);
  auto loaded = patient.apart && plan != nullptr ? session_.load(*plan) : session_.container().load(patient.request);
  Result<void, Problem> done{};
  patient.gone = !loaded;
  if (!loaded) {
    done = err(loaded.error());
  } else if (loaded.value().managed) {
    done = session_.bring_to(loaded.value(), patient.target);
  }
  if (done) {
    session_.say(fmt::format("nacelle: {} was restarted ({} of {})", node, restarts_.count_of(node),
                             patient.handling.max_restarts));
  } else {
    session_.say("nacelle: the restart failed: " + done.error().text());
    plan_restart(node, patient);
  }
  session_.composition_changed();
}

// Who moves the robot goes first, though it is in the middle of the order: a stop frame that was written from outside holds only
// until the next command of a base that is still active.
void Supervision::stop_robot(const runtime::ComponentInfo& cause) {
  runtime::Container& container = session_.container();
  container.stop_what_moves();
  // Nothing comes back by itself.
  restarts_ = {};
  patients_.clear();
  std::vector<runtime::ComponentInfo> order = container.list();
  std::erase_if(order, [](const auto& info) { return !info.managed || info.state != StateId::Active; });
  // The last one that became active goes first.
  const auto place = [this](const auto& info) {
    return std::ranges::find(active_order_, info.node) - active_order_.begin();
  };
  std::ranges::reverse(order);
  std::ranges::stable_sort(order, [&](const auto& a, const auto& b) { return place(a) > place(b); });
  std::stable_partition(order.begin(), order.end(), [](const auto& info) { return info.actuator; });
  std::string failed;
  for (const auto& info : order) {
    const auto outcome = container.trigger(info.id, Transition::Deactivate);
    if (!outcome.success) failed += fmt::format("; {} could not deactivate: {}", info.node, outcome.reason);
  }
  container.write_safe_stops();
  stopped_by_ = cause.node;
  session_.say(fmt::format("nacelle: the robot is stopped: {} is faulted ({}: {}), {} components deactivated{}",
                           cause.node, cause.fault.code, cause.fault.text, order.size(), failed));
}

json Supervision::report() const {
  json rows = json::array(), history = json::array();
  const auto events = session_.container().faults();
  for (const auto& info : session_.container().list()) {
    const runtime::FaultHandling handling = handling_of(info);
    const auto restarts = restarts_.count_of(info.node);
    if (info.fault.code.empty() && info.open_faults.empty() && restarts == 0) continue;
    json row{{"node", info.node},
             {"state", info.managed ? nacelle::to_text(info.state) : ""},
             {"policy", runtime::words_of(handling.policy_for(info.actuator))},
             {"restarts", restarts},
             {"max_restarts", handling.max_restarts}};
    if (!info.fault.code.empty()) row["fault"] = {{"code", info.fault.code}, {"text", info.fault.text}};
    for (const auto& fault : info.open_faults)
      row["open_faults"].push_back({{"code", fault.code}, {"text", fault.text}});
    if (const auto due = restarts_.due_of(info.node))
      row["next_restart_s"] = std::max(0.0, to_seconds(*due - clock_.now()));
    const auto last = std::ranges::find(events.rbegin(), events.rend(), info.node, &runtime::FaultEvent::node);
    if (last != events.rend()) row["last"] = to_json(*last);
    rows.push_back(std::move(row));
  }
  for (const auto& event : events) history.push_back(to_json(event));
  json answer{{"ok", true}, {"components", rows}, {"history", history}, {"robot_stopped_by", nullptr}};
  if (stopped_by_) answer["robot_stopped_by"] = *stopped_by_;
  return answer;
}

}  // namespace nacelle::session
