// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nacelle_interfaces/srv/get_faults.hpp>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/container.hpp"
#include "networking/network.hpp"

namespace nacelle::answers {

/// The phase of the robot.
enum class Phase : std::uint8_t { Starting, Running, Stopping, Down };
[[nodiscard]] constexpr const char* to_text(Phase phase) {
  switch (phase) {
    case Phase::Starting: return "starting";
    case Phase::Running: return "running";
    case Phase::Stopping: return "stopping";
    case Phase::Down: return "down";
  }
  return "?";
}

class Robot;
/// Returns the refusal of a request that only a running robot accepts: RobotFault::NotRunning with the present phase.
[[nodiscard]] Problem why_not_running(const Robot& robot);

/// A topic on which an emergency stop was released, and its number of readers.
struct ReleasedStop {
  std::string topic;
  std::size_t readers = 0;
};

/// The interface of the robot for code that answers queries about it and executes commands. A session implements it. A
/// test may provide a scripted implementation.
///
/// Threads: the main thread, unless stated otherwise.
class Robot {
 public:
  virtual ~Robot() = default;
  /// Returns the container's name, which the control socket has too. Threads: any.
  [[nodiscard]] virtual const std::string& name() const = 0;
  /// Threads: any.
  [[nodiscard]] virtual Phase phase() const = 0;
  /// Threads: any.
  [[nodiscard]] virtual runtime::Container& container() = 0;
  /// Threads: any.
  [[nodiscard]] virtual const launch::Plan& plan() const = 0;
  [[nodiscard]] virtual networking::Network& network() = 0;
  /// Returns the folders with message definitions.
  [[nodiscard]] virtual const std::vector<std::filesystem::path>& message_folders() const = 0;
  /// Returns the faulted components, how their faults are handled, the left-out components, and the last crash.
  /// Threads: any.
  [[nodiscard]] virtual nacelle_interfaces::srv::GetFaults::Response faults() const = 0;
  /// Returns the topics on which an emergency stop is set. Threads: any.
  [[nodiscard]] virtual std::vector<std::string> emergency_stops() const = 0;
  /// Releases the stops on these topics; for an empty list, on every emergency stop topic that a component reads. A
  /// named topic is released even if it has no reader.
  /// Errors: a topic that is not an emergency stop; an empty list, and no component reads such a topic. Threads: any.
  [[nodiscard]] virtual Result<std::vector<ReleasedStop>, Problem> release_emergency_stops(
      const std::vector<std::string>& topics) = 0;

  /// Loads a component of the plan, in this process or in its own. If `faults` is given, it collects the invalid
  /// values; otherwise the first invalid value fails the load.
  [[nodiscard]] virtual Result<runtime::ComponentInfo, Problem> load(
      const launch::ComponentPlan& component, const std::shared_ptr<ParameterFaults>& faults) = 0;
  [[nodiscard]] Result<runtime::ComponentInfo, Problem> load(const launch::ComponentPlan& component) {
    return load(component, nullptr);
  }
  /// Brings a loaded component to a state, one transition after the other. Errors: the first transition that failed,
  /// with its reason.
  [[nodiscard]] Result<void, Problem> bring_to(const runtime::ComponentInfo& component, launch::TargetState target);
  /// Publishes the new composition. Call after components were loaded, unloaded or brought to another state outside the
  /// bring-up.
  virtual void composition_changed() = 0;
  /// Threads: any.
  virtual void request_shutdown() = 0;
};

}  // namespace nacelle::answers
