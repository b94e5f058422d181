// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/controller_services.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <controller_manager_msgs/srv/cleanup_controller.hpp>
#include <controller_manager_msgs/srv/configure_controller.hpp>
#include <controller_manager_msgs/srv/list_controller_types.hpp>
#include <controller_manager_msgs/srv/load_controller.hpp>
#include <controller_manager_msgs/srv/reload_controller_libraries.hpp>
#include <controller_manager_msgs/srv/unload_controller.hpp>
#include <thread>
#include <utility>

namespace nacelle::diff_drive {
namespace {

namespace srv = controller_manager_msgs::srv;

constexpr Duration kDefaultSwitchTimeout = 1s;  // of a request that says 0, as ros2_control's
constexpr Duration kLookForLoop = 1ms;
constexpr const char* kPosition = "position";
constexpr const char* kVelocity = "velocity";

/// A state of managed nodes that lasts.
StateId lasting(ControllerState state) {
  switch (state) {
    case ControllerState::Active: return StateId::Active;
    case ControllerState::Inactive: return StateId::Inactive;
    case ControllerState::Unloaded:
    case ControllerState::Unconfigured: break;
  }
  return StateId::Unconfigured;
}

std::uint16_t whole(double rate_hz) {
  return static_cast<std::uint16_t>(std::lround(std::clamp(rate_hz, 1.0, 65535.0)));
}

/// "a b"
std::string names_of(const ControllerSet& which) {
  std::string names;
  for (std::size_t i = 0; i < which.size(); ++i) {
    if (which[i]) names += (names.empty() ? "" : " ") + std::string(kControllers[i].name);
  }
  return names;
}

}  // namespace

ControllerServices::ControllerServices(const NodeOptions& options, const LifecycleNode& base, CommandInbox& inbox,
                                       Description description)
    : base_(base),
      inbox_(inbox),
      description_(std::move(description)),
      node_("controller_manager", options.another_node()) {
  offer_lists();
  offer_changes();
  offer<srv::SwitchController>("~/switch_controller",
                               [this](const auto& request, auto& response) { switch_controllers(request, response); });
  offer<srv::SetHardwareComponentState>("~/set_hardware_component_state", [this](const auto& request, auto& response) {
    set_hardware_state(request, response);
  });
}

void ControllerServices::describe(Description description) {
  const LockGuard lock(mutex_);
  description_ = std::move(description);
}

void ControllerServices::follow(DriveLoop* loop) {
  const LockGuard lock(mutex_);
  loop_ = loop;
}

template <typename S, typename Answer>
void ControllerServices::offer(const char* name, Answer answer) {
  services_.push_back(node_.create_service<S>(
      name,
      [answer](const typename S::Request& request, typename S::Response& response) { answer(request, response); }));
}

template <typename S, typename Change>
void ControllerServices::offer_change(const char* name, Change change) {
  offer<S>(name, [this, change](const auto& request, auto& response) {
    const LockGuard lock(mutex_);
    const auto done = change(request.name);
    response.ok = done.has_value();
    if (!response.ok) node_.get_logger().error("{}", done.error());
    tell_loop();
  });
}

void ControllerServices::offer_lists() {
  offer<srv::ListControllers>("~/list_controllers", [this](const auto&, auto& response) {
    const LockGuard lock(mutex_);
    list_controllers(response);
  });
  offer<srv::ListControllerTypes>("~/list_controller_types", [](const auto&, auto& response) {
    for (const ControllerKind& kind : kControllers) {
      response.types.emplace_back(kind.type);
      response.base_classes.emplace_back("controller_interface::ControllerInterface");
    }
  });
  offer<srv::ListHardwareComponents>("~/list_hardware_components", [this](const auto&, auto& response) {
    const LockGuard lock(mutex_);
    list_hardware(response);
  });
  offer<srv::ListHardwareInterfaces>("~/list_hardware_interfaces", [this](const auto&, auto& response) {
    const LockGuard lock(mutex_);
    response.command_interfaces = command_interfaces();
    response.state_interfaces = state_interfaces();
  });
}

void ControllerServices::offer_changes() {
  offer_change<srv::LoadController>("~/load_controller", [this](const std::string& name) NACELLE_REQUIRES(mutex_) {
    return controllers_.load(name);
  });
  offer_change<srv::UnloadController>("~/unload_controller", [this](const std::string& name) NACELLE_REQUIRES(mutex_) {
    return controllers_.unload(name, base_state());
  });
  offer_change<srv::ConfigureController>(
      "~/configure_controller",
      [this](const std::string& name) NACELLE_REQUIRES(mutex_) { return controllers_.configure(name, base_state()); });
  offer_change<srv::CleanupController>(
      "~/cleanup_controller",
      [this](const std::string& name) NACELLE_REQUIRES(mutex_) { return controllers_.cleanup(name, base_state()); });
  offer<srv::ReloadControllerLibraries>("~/reload_controller_libraries", [this](const auto&, auto& response) {
    response.ok = false;
    node_.get_logger().error(
        "there are no libraries of controllers to reload: the controllers are a part of the base {}",
        base_.get_fully_qualified_name());
  });
}

ControllerState ControllerServices::base_state() const {
  switch (base_.get_current_state().state()) {
    case StateId::Active: return ControllerState::Active;
    case StateId::Inactive:
    case StateId::Activating:
    case StateId::Deactivating: return ControllerState::Inactive;
    default: return ControllerState::Unconfigured;
  }
}

void ControllerServices::list_controllers(srv::ListControllers::Response& response) const {
  const ControllerState base = base_state();
  for (std::size_t i = 0; i < kControllers.size(); ++i) {
    const ControllerState state = controllers_.state(i, base);
    if (state == ControllerState::Unloaded) continue;
    auto& told = response.controller.emplace_back();
    told.name = kControllers[i].name;
    told.type = kControllers[i].type;
    told.state = to_text(state);
    told.update_rate = whole(description_.update_rate_hz);
    if (state < ControllerState::Inactive) continue;
    told.required_state_interfaces = of_every_joint(kPosition);
    if (i == kDiffDriveController) {
      told.required_command_interfaces = of_every_joint(kVelocity);
      if (state == ControllerState::Active) told.claimed_interfaces = told.required_command_interfaces;
    } else {
      const auto velocities = of_every_joint(kVelocity);
      told.required_state_interfaces.insert(told.required_state_interfaces.end(), velocities.begin(), velocities.end());
    }
  }
}

void ControllerServices::list_hardware(srv::ListHardwareComponents::Response& response) const {
  auto& told = response.component.emplace_back();
  told.name = base_.get_name();
  told.type = "system";
  told.rw_rate = whole(description_.update_rate_hz);
  told.plugin_name = "nacelle_diff_drive/" + description_.hardware;
  const StateId state = lasting(base_state());
  told.state.id = static_cast<std::uint8_t>(state);
  told.state.label = nacelle::to_text(state);
  told.command_interfaces = command_interfaces();
  told.state_interfaces = state_interfaces();
}

std::vector<std::string> ControllerServices::of_every_joint(const char* interface) const {
  std::vector<std::string> names;
  for (const auto* side : {&description_.left_joints, &description_.right_joints}) {
    for (const std::string& joint : *side) names.push_back(joint + "/" + interface);
  }
  return names;
}

bool ControllerServices::is_available() const {
  if (base_state() < ControllerState::Inactive) return false;
  return loop_ == nullptr || (loop_->look().holds & static_cast<std::uint8_t>(Hold::LineLost)) == 0;
}

ControllerServices::Interfaces ControllerServices::command_interfaces() const {
  const bool claimed = controllers_.state(kDiffDriveController, base_state()) == ControllerState::Active;
  Interfaces all;
  for (std::string& name : of_every_joint(kVelocity))
    all.push_back({std::move(name), "double", is_available(), claimed});
  return all;
}

ControllerServices::Interfaces ControllerServices::state_interfaces() const {
  Interfaces all;
  for (const char* const interface : {kPosition, kVelocity}) {
    for (std::string& name : of_every_joint(interface))
      all.push_back({std::move(name), "double", is_available(), false});
  }
  return all;
}

void ControllerServices::tell_loop() {
  const auto runs = [this](std::size_t index) NACELLE_REQUIRES(mutex_) {
    return controllers_.state(index, ControllerState::Active) == ControllerState::Active;
  };
  const bool drives = runs(kDiffDriveController);
  if (!drives) inbox_.inactive.set();
  if (drives && inbox_.inactive.is_set.load()) inbox_.inactive.release(node_.steady_clock().now());
  inbox_.without_joint_states.store(!runs(kJointStateBroadcaster));
  inbox_.orders.fetch_add(1, std::memory_order_release);
  if (loop_ != nullptr) loop_->interrupt();
}

void ControllerServices::set_all(const ControllerSet& which, ControllerState own) {
  const LockGuard lock(mutex_);
  for (std::size_t i = 0; i < which.size(); ++i) {
    if (which[i]) controllers_.set(i, own);
  }
  tell_loop();
}

bool ControllerServices::apply(const ControllerSet& which, ControllerState own, MonotonicTime deadline) {
  if (which == ControllerSet{}) return true;
  set_all(which, own);
  // Without the lock meanwhile: the base may be deactivated while this waits.
  const std::uint32_t order = inbox_.orders.load();
  for (;;) {
    {
      const LockGuard lock(mutex_);
      if (loop_ == nullptr || static_cast<std::int32_t>(loop_->orders_followed() - order) >= 0) return true;
    }
    if (node_.steady_clock().now() >= deadline) return false;
    std::this_thread::sleep_for(kLookForLoop);
  }
}

Duration ControllerServices::time_limit(const builtin_interfaces::msg::Duration& asked) {
  const Duration limit = std::chrono::seconds{asked.sec} + Duration{asked.nanosec};
  if (limit > Duration::zero()) return limit;
  const LockGuard lock(mutex_);
  return std::max(kDefaultSwitchTimeout, from_seconds(2.0 / description_.update_rate_hz));
}

Result<SwitchPlan, std::string> ControllerServices::plan(const srv::SwitchController::Request& request) {
  using Request = srv::SwitchController::Request;
  if (request.strictness < 0 || request.strictness > Request::FORCE_AUTO)
    return err(fmt::format("strictness {} is not BEST_EFFORT (1) or STRICT (2)", request.strictness));
  if (request.strictness > Request::STRICT)
    node_.get_logger().warn("AUTO and FORCE_AUTO are not implemented; the switch is done with BEST_EFFORT");
  const LockGuard lock(mutex_);
  return controllers_.plan(
      {request.activate_controllers, request.deactivate_controllers, request.strictness == Request::STRICT},
      base_state());
}

void ControllerServices::switch_controllers(const srv::SwitchController::Request& request,
                                            srv::SwitchController::Response& response) {
  const auto refuse = [&](std::string why) {
    node_.get_logger().error("no controller is switched: {}", why);
    response.ok = false;
    response.message = std::move(why);
  };
  const auto planned = plan(request);
  if (!planned) return refuse(planned.error());
  const SwitchPlan& todo = *planned;
  for (const std::string& why : todo.left_out) node_.get_logger().warn("{}", why);
  response.ok = true;
  if (todo.is_empty()) {
    response.message = "After checking the controllers, no controllers need to be activated or deactivated.";
    return;
  }
  const Duration limit = time_limit(request.timeout);
  const MonotonicTime deadline = node_.steady_clock().now() + limit;
  const auto late = [&](const char* what) {
    response.ok = false;
    response.message = fmt::format("Switch controller timed out after {} seconds! {}", to_seconds(limit), what);
    node_.get_logger().error("{}", response.message);
  };
  if (!apply(todo.deactivates, ControllerState::Inactive, deadline))
    return late("What was to be deactivated is inactive; nothing was activated.");
  if (!apply(todo.activates, ControllerState::Active, deadline)) {
    set_all(todo.activates, ControllerState::Inactive);
    return late("What was to be activated is inactive.");
  }
  response.message = "Successfully switched controllers!";
  for (const auto& [done, which] :
       {std::pair{"Deactivated", todo.deactivates}, std::pair{"Activated", todo.activates}}) {
    if (which == ControllerSet{}) continue;
    const std::string line = fmt::format("{} controllers: [ {} ]", done, names_of(which));
    node_.get_logger().info("{}", line);
    response.message += "\n" + line;
  }
}

void ControllerServices::set_hardware_state(const srv::SetHardwareComponentState::Request& request,
                                            srv::SetHardwareComponentState::Response& response) {
  if (request.name != base_.get_name()) {
    node_.get_logger().error("hardware component with name '{}' does not exist; there is {}", request.name,
                             base_.get_name());
    return;
  }
  const StateId state = lasting(base_state());
  response.state.id = static_cast<std::uint8_t>(state);
  response.state.label = nacelle::to_text(state);
  const auto& target = request.target_state;
  response.ok = target.id == response.state.id || (target.id == 0 && target.label == response.state.label);
  if (response.ok) return;
  node_.get_logger().error(
      "the state of {} is the base's own: `ros2 lifecycle set {}` or `nacelle lifecycle set {}` changes it",
      request.name, base_.get_fully_qualified_name(), request.name);
}

}  // namespace nacelle::diff_drive
