// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle {

/// What follows when a component is faulted.
enum class FaultPolicy : std::uint8_t {
  Degrade,  ///< It stays faulted, the others go on.
  Restart,  ///< It is loaded anew and taken to where it was, after a pause, so many times; then it is left to degrade.
  StopRobot,  ///< Every registered stop frame is written at once, then all components are deactivated.
  /// As StopRobot; then the container ends with an error, so that its service manager starts it anew.
  RestartContainer,
};
/// "degrade", "restart", "stop_robot", "restart_container": as in launch files, messages and state files.
[[nodiscard]] constexpr const char* to_text(FaultPolicy policy) {
  switch (policy) {
    case FaultPolicy::Degrade: return "degrade";
    case FaultPolicy::Restart: return "restart";
    case FaultPolicy::StopRobot: return "stop_robot";
    case FaultPolicy::RestartContainer: return "restart_container";
  }
  return "?";
}

/// The policy of one component, with the bounds of its restarts.
struct FaultHandling {
  std::optional<FaultPolicy>
      policy{};                    ///< None: StopRobot for a component that moves something, Degrade for the others.
  std::uint32_t max_restarts = 3;  ///< In a row: one that was active for a minute begins anew.
  Duration backoff = std::chrono::seconds{1};  ///< Before each restart.
  [[nodiscard]] FaultPolicy policy_for(bool actuator) const {
    return policy.value_or(actuator ? FaultPolicy::StopRobot : FaultPolicy::Degrade);
  }
  /// Returns whether everything that moves is stopped at once.
  [[nodiscard]] bool stops_robot(bool actuator) const {
    const FaultPolicy now = policy_for(actuator);
    return now == FaultPolicy::StopRobot || now == FaultPolicy::RestartContainer;
  }
  friend bool operator==(const FaultHandling&, const FaultHandling&) = default;
};

}  // namespace nacelle
