// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/model/controllers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

namespace nacelle::diff_drive {
namespace {

std::optional<std::size_t> index_of(std::string_view name) {
  for (std::size_t i = 0; i < kControllers.size(); ++i) {
    if (name == kControllers[i].name) return i;
  }
  return std::nullopt;
}

}  // namespace

const char* to_text(ControllerState state) {
  switch (state) {
    case ControllerState::Unloaded: return "unloaded";
    case ControllerState::Unconfigured: return "unconfigured";
    case ControllerState::Inactive: return "inactive";
    case ControllerState::Active: return "active";
  }
  return "unknown";
}

ControllerState Controllers::state(std::size_t index, ControllerState base) const {
  return std::min(own_[index], base);
}

Result<std::size_t, std::string> Controllers::find(std::string_view name, const char* action) const {
  const auto index = index_of(name);
  if (index && own_[*index] != ControllerState::Unloaded) return *index;
  std::string known;
  for (std::size_t i = 0; i < kControllers.size(); ++i) {
    if (own_[i] != ControllerState::Unloaded) known += (known.empty() ? "" : ", ") + std::string(kControllers[i].name);
  }
  return err(
      fmt::format("Could not {} controller with name '{}' because no controller with this name exists (loaded: {})",
                  action, name, known.empty() ? "none" : known));
}

Result<ControllerSet, std::string> Controllers::find_all(const std::vector<std::string>& names, const char* action,
                                                         bool is_strict, std::vector<std::string>& left_out) const {
  ControllerSet found{};
  std::string unknown;
  bool any = names.empty();
  for (const std::string& name : names) {
    const auto index = find(name, action);
    if (index) {
      any = found[*index] = true;
      continue;
    }
    unknown += (unknown.empty() ? "" : "\n") + index.error();
    left_out.push_back(index.error());
  }
  if (!unknown.empty() && (is_strict || !any)) return err(std::move(unknown));
  return found;
}

std::string Controllers::obstacle_to_activate(std::size_t index, ControllerState base, bool is_restart) const {
  const char* const name = kControllers[index].name;
  switch (state(index, base)) {
    case ControllerState::Active:
      return is_restart ? std::string{} : fmt::format("Controller with name '{}' is already active", name);
    case ControllerState::Inactive: return {};
    case ControllerState::Unloaded:
    case ControllerState::Unconfigured: break;
  }
  return fmt::format("Controller with name '{}' is in 'unconfigured' state; configure {} first", name,
                     base < ControllerState::Inactive ? "the base" : "it");
}

std::string Controllers::obstacle_to_deactivate(std::size_t index, ControllerState base) const {
  if (state(index, base) == ControllerState::Active) return {};
  return fmt::format("Controller with name '{}' can not be deactivated since it is not active",
                     kControllers[index].name);
}

Result<SwitchPlan, std::string> Controllers::plan(const SwitchOrder& order, ControllerState base) const {
  SwitchPlan plan;
  const auto deactivates = find_all(order.deactivate, "deactivate", order.is_strict, plan.left_out);
  if (!deactivates) return err(deactivates.error());
  const auto activates = find_all(order.activate, "activate", order.is_strict, plan.left_out);
  if (!activates) return err(activates.error());
  plan.deactivates = *deactivates;
  plan.activates = *activates;

  const auto leave_out = [&plan](ControllerSet& part, std::size_t index, std::string why) {
    part[index] = false;
    plan.left_out.push_back(std::move(why));
  };
  for (std::size_t i = 0; i < kControllers.size(); ++i) {
    if (plan.activates[i]) {
      std::string why = obstacle_to_activate(i, base, plan.deactivates[i]);
      if (!why.empty() && order.is_strict) return err(std::move(why));
      if (!why.empty()) leave_out(plan.activates, i, std::move(why));
    }
    if (plan.deactivates[i]) {
      std::string why = obstacle_to_deactivate(i, base);
      if (!why.empty() && order.is_strict) return err(std::move(why));
      if (!why.empty()) leave_out(plan.deactivates, i, std::move(why));
    }
  }
  if (plan.activates != ControllerSet{} && base != ControllerState::Active) {
    return err(fmt::format(
        "Could not activate controllers: their interfaces are not available, since the base is {}; activate it",
        to_text(base)));
  }
  return plan;
}

Result<void, std::string> Controllers::load(std::string_view name) {
  const auto index = index_of(name);
  if (!index) {
    return err(fmt::format("Could not load controller with name '{}': this base has {} and {} only", name,
                           kControllers[kDiffDriveController].name, kControllers[kJointStateBroadcaster].name));
  }
  if (own_[*index] != ControllerState::Unloaded)
    return err(fmt::format("A controller named '{}' was already loaded", name));
  own_[*index] = ControllerState::Unconfigured;
  return {};
}

Result<void, std::string> Controllers::unload(std::string_view name, ControllerState base) {
  const auto index = find(name, "unload");
  if (!index) return err(index.error());
  if (state(*index, base) == ControllerState::Active)
    return err(fmt::format("Could not unload controller with name '{}' because it is still active", name));
  own_[*index] = ControllerState::Unloaded;
  return {};
}

Result<void, std::string> Controllers::configure(std::string_view name, ControllerState base) {
  const auto index = find(name, "configure");
  if (!index) return err(index.error());
  if (state(*index, base) == ControllerState::Active)
    return err(fmt::format("Controller '{}' can not be configured from 'active' state", name));
  if (base < ControllerState::Inactive)
    return err(
        fmt::format("Could not configure controller with name '{}': the base is unconfigured; configure it", name));
  own_[*index] = std::max(own_[*index], ControllerState::Inactive);
  return {};
}

Result<void, std::string> Controllers::cleanup(std::string_view name, ControllerState base) {
  const auto index = find(name, "cleanup");
  if (!index) return err(index.error());
  const ControllerState now_is = state(*index, base);
  if (now_is == ControllerState::Active)
    return err(fmt::format("Controller '{}' can not be cleaned-up from 'active' state", name));
  if (now_is == ControllerState::Inactive) own_[*index] = ControllerState::Unconfigured;
  return {};
}

}  // namespace nacelle::diff_drive
