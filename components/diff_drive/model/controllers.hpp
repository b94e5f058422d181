// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/result.hpp"

namespace nacelle::diff_drive {

/// The state of a controller, ordered: each one needs what those before it need. Unloaded is not a state of ros2_control;
/// such a controller is not listed.
enum class ControllerState : std::uint8_t { Unloaded, Unconfigured, Inactive, Active };
/// lifecycle_msgs' labels: "unconfigured", "inactive", "active"; "unloaded".
[[nodiscard]] const char* to_text(ControllerState state);

/// A controller that is a part of the base.
struct ControllerKind {
  const char* name;
  const char* type;
};
inline constexpr std::size_t kDiffDriveController = 0;    ///< Follows commands.
inline constexpr std::size_t kJointStateBroadcaster = 1;  ///< Publishes joint_states.
inline constexpr std::array<ControllerKind, 2> kControllers{{
    {"diff_drive_controller", "diff_drive_controller/DiffDriveController"},
    {"joint_state_broadcaster", "joint_state_broadcaster/JointStateBroadcaster"},
}};

/// Some of them.
using ControllerSet = std::array<bool, kControllers.size()>;

/// An order to activate and deactivate controllers, as controller_manager_msgs/srv/SwitchController.
struct SwitchOrder {
  std::vector<std::string> activate, deactivate;
  bool is_strict = false;  ///< Refuses the whole order if a part of it cannot be done; else the rest is done.
};
/// What to do: first all of `deactivates`, then all of `activates`. A controller in both is restarted.
struct SwitchPlan {
  ControllerSet activates{}, deactivates{};
  std::vector<std::string> left_out;  ///< Parts of the order that are not done, each with its reason.
  [[nodiscard]] bool is_empty() const { return activates == ControllerSet{} && deactivates == ControllerSet{}; }
};

/// The states of the controllers of one base, and which changes of them are allowed.
///
/// A controller has a state of its own, which only orders change; it begins as Active. What others see is that state, limited by
/// the base's: while the base is inactive, no controller is active. A controller that was deactivated therefore stays so when the
/// base is deactivated and activated.
///
/// Source:  the rules of ros2_control's ControllerManager (jazzy 9ffbf97, controller_manager.cpp), without chained controllers.
/// Errors:  each a sentence for the user.
/// Threads: one at a time.
class Controllers {
 public:
  /// `base` is the state of the base in all of these: Unconfigured, Inactive or Active.
  [[nodiscard]] ControllerState state(std::size_t index, ControllerState base) const;

  /// Unknown names are refused by name; with a strict order any of them, else a list in which no name is known.
  [[nodiscard]] Result<SwitchPlan, std::string> plan(const SwitchOrder& order, ControllerState base) const;
  /// Sets the controller's own state, as a plan or its failure demands.
  void set(std::size_t index, ControllerState own) { own_[index] = own; }

  /// Unloaded -> Unconfigured.
  [[nodiscard]] Result<void, std::string> load(std::string_view name);
  /// Unconfigured or Inactive -> Unloaded.
  [[nodiscard]] Result<void, std::string> unload(std::string_view name, ControllerState base);
  /// Unconfigured -> Inactive; does nothing to an inactive one.
  [[nodiscard]] Result<void, std::string> configure(std::string_view name, ControllerState base);
  /// Inactive -> Unconfigured; does nothing to an unconfigured one.
  [[nodiscard]] Result<void, std::string> cleanup(std::string_view name, ControllerState base);

 private:
  /// The index of a loaded controller.
  [[nodiscard]] Result<std::size_t, std::string> find(std::string_view name, const char* action) const;
  [[nodiscard]] Result<ControllerSet, std::string> find_all(const std::vector<std::string>& names, const char* action,
                                                            bool is_strict, std::vector<std::string>& left_out) const;
  /// Why a loaded controller cannot be activated or deactivated; empty if it can.
  [[nodiscard]] std::string obstacle_to_activate(std::size_t index, ControllerState base, bool is_restart) const;
  [[nodiscard]] std::string obstacle_to_deactivate(std::size_t index, ControllerState base) const;

  std::array<ControllerState, kControllers.size()> own_{ControllerState::Active, ControllerState::Active};
};

}  // namespace nacelle::diff_drive
