// SPDX-License-Identifier: Apache-2.0
// The handling and reporting of faulted components.
#include <fmt/format.h>

#include <algorithm>

#include "container_impl.hpp"
#include "nacelle/base/journal.hpp"

namespace nacelle::runtime {
namespace {

// A component that has refused a transition continues as before, so it can still become faulted.
constexpr const char* kTransitionFailed = "TRANSITION_FAILED";

}  // namespace

bool Container::Impl::keep_reason(Record& record, const std::string& code, const std::string& text,
                                  const std::string& callback) {
  {
    auto fault = record.fault.lock();
    if (!fault->code.empty() && fault->code != kTransitionFailed) return false;
    *fault = {code, text};
  }
  const std::string& node = record.runtime->identity().fully_qualified();
  history.lock()->add({0, node, code, text, callback, commons.clock.wall_now()});
  write_about(
      node, log, LogLevel::Error,
      fmt::format("{} is faulted: {}: {}{}", node, code, text, callback.empty() ? "" : " (in " + callback + ")"));
  return true;
}

void Container::Impl::note_fault(Record& record, const std::string& code, const std::string& text,
                                 const std::string& callback) {
  if (!keep_reason(record, code, text, callback)) {
    // It is already faulted, and its error processing cannot begin, or does not return.
    if (code == "HUNG" && !record.hung) {
      history.lock()->add(
          {0, record.runtime->identity().fully_qualified(), code, text, callback, commons.clock.wall_now()});
      give_up_on(record);
    }
    return;
  }
  record.for_each_node([](const NodeRuntime& node) { node.write_safe_stop(); });
  // At once, on the thread that detects the fault: the rest of the handling may have to wait for a callback to return.
  if (record.request.lock()->on_fault.stops_robot(record.is_actuator())) stop_what_moves();
  if (code == "HUNG") return give_up_on(record);
  record.runtime->post("on_error", patience, [this, &record, reason = FaultReason{code, text}] {
    if (record.hung) return;  // abandoned meanwhile, and that has been reported
    if (record.managed != nullptr) {
      const StateWatch watch = watch_states(record);
      static_cast<void>(record.managed->process_fault(reason));
    }
    if (record.hung) return;
    tell_listener(record);
    note_change();
  });
}

// No transition, no stop frame, no policy: the component repairs the problem and reports when.
void Container::Impl::note_open_fault(Record& record, const std::string& code, const std::string& text,
                                      const std::string& callback) {
  bool is_new = false;
  {
    auto open = record.open_faults.lock();
    const auto same = std::ranges::find(*open, code, [](const auto& fault) { return fault.reason.code; });
    is_new = same == open->end();
    if (is_new) {
      open->push_back({{code, text}, commons.clock.now()});
    } else {
      same->reason.text = text;
    }
  }
  if (!is_new) return note_change();
  FaultEvent event{0, record.runtime->identity().fully_qualified(), code, text, callback, commons.clock.wall_now()};
  event.is_open_fault = true;
  tell_open_fault(std::move(event));
}

void Container::Impl::note_closed_fault(Record& record, const std::string& code) {
  FaultEvent event{0, record.runtime->identity().fully_qualified(), code, {}, {}, commons.clock.wall_now()};
  event.is_open_fault = true;
  {
    auto open = record.open_faults.lock();
    const auto found = std::ranges::find(*open, code, [](const auto& fault) { return fault.reason.code; });
    if (found == open->end()) return;
    event.text = found->reason.text;
    event.lasted = commons.clock.now() - found->since;
    open->erase(found);
  }
  tell_open_fault(std::move(event));
}

void Container::Impl::tell_open_fault(FaultEvent event) {
  if (event.lasted) {
    history.lock()->end(event.node, event.code, *event.lasted);
    write_about(
        event.node, log, LogLevel::Info,
        fmt::format("{}: the fault {} is closed after {:.1f} s", event.node, event.code, to_seconds(*event.lasted)));
  } else {
    history.lock()->add(event);
    write_about(event.node, log, LogLevel::Error, fmt::format("{}: {}: {}", event.node, event.code, event.text));
  }
  {
    auto listener = open_fault_listener.lock();
    if (*listener) (*listener)(event);
  }
  note_change();
}

void Container::Impl::give_up_on(Record& record) {
  record.hung = true;
  for (const auto& node : record.runtimes()) {
    node->set_active(false);
    node->write_safe_stop();
  }
  tell_listener(record);
  note_change();
}

// The requester of the transition gets the failure and decides, so the reason is recorded, and no policy runs.
void Container::Impl::note_failed_transition(Record& record, Transition transition, const TransitionOutcome& outcome) {
  *record.fault.lock() = {};  // replaced by this reason
  static_cast<void>(keep_reason(record, kTransitionFailed, outcome.reason,
                                std::string{"transition on_"} + nacelle::to_text(transition)));
  if (outcome.state == StateId::Active) return;
  record.for_each_node([](const NodeRuntime& node) { node.write_safe_stop(); });
}

StateWatch Container::Impl::watch_states(const Record& record) {
  return StateWatch{[this, node = record.runtime->identity().fully_qualified()](StateId from, StateId to) {
    // Under its lock: once on_state({}) has returned, no thread is in the listener, not even one that hung and has
    // returned.
    auto listener = state_listener.lock();
    if (*listener) (*listener)({node, from, to, commons.clock.wall_now()});
  }};
}

void Container::Impl::tell_listener(Record& record) {
  const ComponentInfo info = info_of(record);
  auto listener = fault_listener.lock();
  if (*listener) (*listener)(info);
}

void Container::Impl::note_change() const {
  auto listener = change_listener.lock();
  if (*listener) (*listener)();
}

void Container::Impl::write_safe_stops() const {
  commons.motion_stops->count.fetch_add(1);
  std::vector<std::shared_ptr<ForeignComponent>> others;
  {
    const LockGuard lock(mutex);
    for (const auto& [id, component] : foreign) others.push_back(component);
    for (const auto& [id, record] : records) {
      record->for_each_node([](const NodeRuntime& node) { node.write_safe_stop(); });
    }
  }
  for (const auto& component : others) component->stop_what_moves();
}

// A stop frame alone would hold only until the next command, and deactivating the components may take seconds. A base
// that watches MotionStops sends no more commands. For other bases the gate is closed, so they follow their last
// command until it times out.
void Container::Impl::stop_what_moves() const {
  commons.motion_stops->count.fetch_add(1);
  std::vector<std::shared_ptr<NodeRuntime>> movers;
  std::vector<std::shared_ptr<ForeignComponent>> others;
  {
    const LockGuard lock(mutex);
    for (const auto& [id, component] : foreign) others.push_back(component);
    for (const auto& [id, record] : records) {
      for (auto& node : record->runtimes()) {
        if (node->is_actuator()) movers.push_back(std::move(node));
      }
    }
  }
  for (const auto& mover : movers) {
    mover->set_active(false);
    mover->write_safe_stop();
  }
  for (const auto& component : others) component->stop_what_moves();
}

void Container::stop_what_moves() const { impl_->stop_what_moves(); }

std::vector<FaultEvent> Container::faults() const { return impl_->history.lock()->all(); }

void Container::on_fault(std::function<void(const ComponentInfo&)> callback) {
  *impl_->fault_listener.lock() = std::move(callback);
}
void Container::on_state(std::function<void(const StateChange&)> callback) {
  *impl_->state_listener.lock() = std::move(callback);
}
void Container::on_open_fault(std::function<void(const FaultEvent&)> callback) {
  *impl_->open_fault_listener.lock() = std::move(callback);
}
void Container::on_change(std::function<void()> callback) { *impl_->change_listener.lock() = std::move(callback); }

}  // namespace nacelle::runtime
