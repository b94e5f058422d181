// SPDX-License-Identifier: Apache-2.0
#include "diff_drive/component/hindrance.hpp"

#include <fmt/format.h>

namespace nacelle::diff_drive {

Hindrance hindrance_of(const DriveLoop::Look& look, const char* board_fault) {
  using diagnostic_msgs::msg::DiagnosticStatus;
  const auto held = [&](Hold why) { return (look.holds & static_cast<std::uint8_t>(why)) != 0; };
  if (held(Hold::LineLost))
    return {"the motor board is disconnected or silent; reconnecting until it is back", DiagnosticStatus::ERROR};
  if (held(Hold::BoardFault))
    return {fmt::format("the motor board reports a fault: {}", board_fault != nullptr ? board_fault : "gone just now"),
            DiagnosticStatus::ERROR};
  if (held(Hold::Stopped))
    return {"it was stopped from outside; deactivate it and activate it again", DiagnosticStatus::ERROR};
  if (held(Hold::EmergencyStop))
    return {"the emergency stop is set; `nacelle estop release` releases it", DiagnosticStatus::ERROR};
  if (held(Hold::Unguarded))
    return {"the emergency stop has no publisher, or its publisher hangs (emergency_stop_required)",
            DiagnosticStatus::ERROR};
  if (held(Hold::Inactive)) {
    return {
        "diff_drive_controller is not active; `ros2 control switch_controllers --activate diff_drive_controller` "
        "activates it",
        DiagnosticStatus::WARN};
  }
  if (look.state == CommandInput::State::Locked)
    return {"a lock blocks the input that would command it", DiagnosticStatus::WARN};
  if (look.waits_for_neutral) {
    return {
        "after a stop it waits for commands of zero, or none, for one timeout before it follows any (rearm: neutral)",
        DiagnosticStatus::WARN};
  }
  return {};
}

}  // namespace nacelle::diff_drive
