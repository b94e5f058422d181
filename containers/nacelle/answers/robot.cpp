// SPDX-License-Identifier: Apache-2.0
#include "answers/robot.hpp"

#include "answers/robot_fault.hpp"
#include "nacelle/base/lifecycle_fault.hpp"

namespace nacelle::answers {

Problem why_not_running(const Robot& robot) {
  const char* const phase = to_text(robot.phase());
  return {"container " + robot.name(), std::string{"it is "} + phase, "try again when it is running",
          RobotFault::NotRunning, phase};
}

Result<void, Problem> Robot::bring_to(const runtime::ComponentInfo& component, launch::TargetState target) {
  std::vector<Transition> steps;
  if (target != launch::TargetState::Unconfigured) steps.push_back(Transition::Configure);
  if (target == launch::TargetState::Active) steps.push_back(Transition::Activate);
  for (const Transition step : steps) {
    const TransitionOutcome outcome = container().trigger(component.id, step);
    if (!outcome.success)
      return err(Problem{component.node, std::string{"could not "} + nacelle::to_text(step) + ": " + outcome.reason, "",
                         LifecycleFault::TransitionFailed, nacelle::to_text(step)});
  }
  return {};
}

}  // namespace nacelle::answers
