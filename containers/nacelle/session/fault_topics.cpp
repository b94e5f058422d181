// SPDX-License-Identifier: Apache-2.0
#include "session/fault_topics.hpp"

#include <algorithm>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <lifecycle_msgs/msg/transition_event.hpp>
#include <set>

#include "nacelle/base/names.hpp"

namespace nacelle::session {
namespace {

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using lifecycle_msgs::msg::TransitionEvent;

DiagnosticStatus status_of(const runtime::ComponentInfo& info, const std::vector<runtime::FaultEvent>& history) {
  DiagnosticStatus status;
  status.name = info.node;
  status.hardware_id = info.plugin;
  if (info.fault.code.empty() && info.open_faults.empty()) {
    status.level = DiagnosticStatus::OK;
    status.message = nacelle::to_text(info.state);
    return status;
  }
  status.level = DiagnosticStatus::ERROR;
  const FaultReason& fault = info.fault.code.empty() ? info.open_faults.front() : info.fault;
  status.message = fault.code + ": " + fault.text;
  const auto add = [&](const char* key, std::string value) {
    status.values.emplace_back();
    status.values.back().key = key;
    status.values.back().value = std::move(value);
  };
  add("code", fault.code);
  add("state", nacelle::to_text(info.state));
  std::size_t count = 0;
  for (const auto& event : history) count += event.node == info.node ? 1U : 0U;
  add("faults", std::to_string(count));
  const auto last = std::find_if(history.rbegin(), history.rend(), [&](const auto& e) { return e.node == info.node; });
  if (last != history.rend()) add("callback", last->callback);
  return status;
}

}  // namespace

TransitionName name_of_step(StateId from, StateId to) {
  constexpr std::uint8_t kCallbackError = 99;
  const bool primary = static_cast<std::uint8_t>(from) < 10;
  switch (to) {
    case StateId::Configuring: return {1, "configure"};
    case StateId::CleaningUp: return {2, "cleanup"};
    case StateId::Activating: return {3, "activate"};
    case StateId::Deactivating: return {4, "deactivate"};
    case StateId::ShuttingDown:
      // 5, 6 and 7: from unconfigured, inactive and active, which are 1, 2 and 3.
      return {static_cast<std::uint8_t>(4 + static_cast<std::uint8_t>(from)), "shutdown"};
    default: break;
  }
  // A fault comes from outside of any transition, which rcl_lifecycle does not know.
  if (primary) return {kCallbackError, "transition_error"};
  const auto step = [&](std::uint8_t success, StateId good, StateId bad) -> TransitionName {
    if (to == good) return {success, "transition_success"};
    if (to == bad) return {static_cast<std::uint8_t>(success + 1), "transition_failure"};
    return {static_cast<std::uint8_t>(success + 2), "transition_error"};
  };
  switch (from) {
    case StateId::Configuring: return step(10, StateId::Inactive, StateId::Unconfigured);
    case StateId::CleaningUp: return step(20, StateId::Unconfigured, StateId::Inactive);
    case StateId::Activating: return step(30, StateId::Active, StateId::Inactive);
    case StateId::Deactivating: return step(40, StateId::Inactive, StateId::Active);
    case StateId::ShuttingDown: return step(50, StateId::Finalized, StateId::Unknown);
    default: return step(60, StateId::Unconfigured, StateId::Finalized);  // error processing
  }
}

FaultTopics::FaultTopics(runtime::Container& container)
    : container_(container),
      diagnostics_(container.transport().create_writer(
          {"/diagnostics", &DiagnosticArray::message_type(), QoS{10},
           fully_qualified_node_name(container.options().name_space, container.options().name)})) {}

FaultTopics::~FaultTopics() = default;

void FaultTopics::follow(const std::vector<runtime::ComponentInfo>& components) {
  std::set<std::string> managed;
  for (const auto& info : components) {
    if (info.managed) managed.insert(info.node);
  }
  std::erase_if(events_, [&](const auto& entry) { return !managed.contains(entry.first); });
  for (const auto& node : managed) {
    auto& writer = events_[node];
    if (!writer)
      writer = container_.transport().create_writer(
          {node + "/transition_event", &TransitionEvent::message_type(), QoS{10}, node});
  }
}

void FaultTopics::publish(const runtime::StateChange& change) {
  const auto found = events_.find(change.node);
  if (found == events_.end()) return;
  Block* const block = found->second->borrow();
  if (block == nullptr) return;
  auto& event = *static_cast<TransitionEvent*>(block->message);
  event = {};
  event.timestamp = static_cast<std::uint64_t>(change.when.nanoseconds());
  const TransitionName name = name_of_step(change.from, change.to);
  event.transition.id = name.id;
  event.transition.label = name.label;
  event.start_state.id = static_cast<std::uint8_t>(change.from);
  event.start_state.label = nacelle::to_text(change.from);
  event.goal_state.id = static_cast<std::uint8_t>(change.to);
  event.goal_state.label = nacelle::to_text(change.to);
  static_cast<void>(found->second->publish(*block));
}

bool FaultTopics::publish_diagnostics(const std::vector<runtime::ComponentInfo>& components,
                                      const std::vector<Absent>& absent) {
  std::vector<std::string> faulted;
  std::vector<const runtime::ComponentInfo*> told;
  for (const auto& info : components) {
    const bool was = std::ranges::find(were_faulted_, info.node) != were_faulted_.end();
    const bool is_faulted = !info.fault.code.empty() || !info.open_faults.empty();
    if (is_faulted) faulted.push_back(info.node);
    if (was || is_faulted) told.push_back(&info);
  }
  for (const auto& component : absent) faulted.push_back(component.node);
  were_faulted_ = std::move(faulted);
  if (told.empty() && absent.empty()) return false;
  Block* const block = diagnostics_->borrow();
  if (block == nullptr) return !were_faulted_.empty();
  auto& message = *static_cast<DiagnosticArray*>(block->message);
  message = {};
  message.header.stamp = container_.clock().wall_now();
  const auto history = container_.faults();
  for (const auto* const info : told) message.status.push_back(status_of(*info, history));
  for (const auto& component : absent) {
    auto& status = message.status.emplace_back();
    status.level = DiagnosticStatus::ERROR;
    status.name = component.node;
    status.hardware_id = component.plugin;
    status.message = "LEFT_OUT: " + component.why;
  }
  static_cast<void>(diagnostics_->publish(*block));
  return !were_faulted_.empty();
}

}  // namespace nacelle::session
