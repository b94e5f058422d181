// SPDX-License-Identifier: Apache-2.0
#include "answers/robot.hpp"

namespace nacelle::answers {

Result<void, Problem> Robot::bring_to(const runtime::ComponentInfo& component, launch::TargetState target) {
  std::vector<Transition> steps;
  if (target != launch::TargetState::Unconfigured) steps.push_back(Transition::Configure);
  if (target == launch::TargetState::Active) steps.push_back(Transition::Activate);
  for (const Transition step : steps) {
    const TransitionOutcome outcome = container().trigger(component.id, step);
    if (!outcome.success)
      return err(
          Problem{component.node, std::string{"could not "} + nacelle::to_text(step) + ": " + outcome.reason, ""});
  }
  return {};
}

}  // namespace nacelle::answers
