// SPDX-License-Identifier: Apache-2.0
#include "session/comeback.hpp"

#include <algorithm>

#include "loading/load_request.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/names.hpp"
#include "session/supervision.hpp"

namespace nacelle::session {
namespace {

using launch::TargetState;

// Maps a state that is being left, or that cannot be restored, to the one before it.
TargetState target_of(StateId state) {
  switch (state) {
    case StateId::Active:
    case StateId::Deactivating: return TargetState::Active;
    case StateId::Inactive:
    case StateId::Activating:
    case StateId::CleaningUp: return TargetState::Inactive;
    default: return TargetState::Unconfigured;
  }
}

launch::ComponentPlan plan_of(const runtime::ComponentInfo& info, const runtime::LoadRequest& request) {
  launch::ComponentPlan plan;
  plan.plugin = request.plugin;
  const std::size_t slash = info.node.rfind('/');
  plan.name = info.node.substr(slash + 1);
  plan.namespace_ = slash == 0 ? "/" : info.node.substr(0, slash);
  plan.remaps = request.remaps;
  plan.thread = request.thread;
  plan.on_fault = request.on_fault;
  return plan;
}

}  // namespace

Composition composition_of(answers::Robot& robot, const Supervision& supervision,
                           const std::vector<ComposedComponent>& left_out) {
  Composition composition{robot.name(), {}, robot.emergency_stops()};
  for (const auto& info : robot.container().list()) {
    ComposedComponent component;
    const auto request = robot.container().request_of(info.id);
    const auto* const written = robot.plan().find(info.node);
    if (written != nullptr && written->plugin == info.plugin) {
      component.plan = *written;
    } else if (request) {
      component.plan = plan_of(info, *request);
    } else {
      continue;  // of another process, and no longer in the plan: it cannot be restored
    }
    if (request) component.plan.parameters = loading::parameters_of(*request);
    component.plan.target =
        info.managed ? supervision.target_of_restart(info.node).value_or(target_of(info.state)) : TargetState::Active;
    component.actuator = info.actuator || supervision.was_actuator(info.node);
    composition.components.push_back(std::move(component));
  }
  // Components that were left out stay recorded, so that a later restart restores them if they were loaded by hand meanwhile.
  for (const auto& component : left_out) {
    const auto same = [&](const ComposedComponent& other) {
      return other.plan.full_name() == component.plan.full_name();
    };
    if (std::ranges::none_of(composition.components, same)) composition.components.push_back(component);
  }
  return composition;
}

std::string crash_file_of(const std::string& state_file) { return state_file + ".crash"; }

std::optional<CrashFacts> read_crash(const std::string& crash_file) {
  const auto text = read_regular_file(crash_file);
  if (!text) return std::nullopt;
  return crash_facts(text.value());
}

}  // namespace nacelle::session
