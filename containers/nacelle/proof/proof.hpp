// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "loading/program_places.hpp"
#include "nacelle/launch/plan.hpp"
#include "nacelle/runtime/budget.hpp"
#include "nacelle/runtime/container.hpp"
#include "proof/finding.hpp"

namespace nacelle::proof {

/// A component of the plan after its load.
struct LoadedComponent {
  const launch::ComponentPlan* plan = nullptr;
  std::optional<Problem> failure;                         ///< Why it could not be made.
  std::shared_ptr<const runtime::Declarations> declared;  ///< Null if it was not made.
  std::vector<ParameterFault> faults;                     ///< Values that it cannot have.

  [[nodiscard]] bool has_fault_of(std::string_view parameter) const;
};

/// Everything that is wrong with a plan whose components were made and not configured: parameters, plugins, types and QoS of
/// every pair, remaps, frames, budgets, programs, conditions. The same for `nacelle check` and for a launch, before it activates.
///
/// What concerns only a component with `required: false` is a warning: the launch goes on without it.
/// Threads: any, while no component is being loaded.
[[nodiscard]] std::vector<Finding> prove(const launch::Plan& plan, const loading::ProgramPlaces& places,
                                         runtime::Container& container, const std::vector<LoadedComponent>& loaded);

/// Where the plan gives a parameter to the component; else where the component stands.
[[nodiscard]] Place place_of_parameter(const launch::ComponentPlan& plan, const std::string& parameter);

/// Budgets with the topics that they mean: all that the component publishes, where it names none.
[[nodiscard]] std::vector<runtime::StreamBudget> stream_budgets(const launch::Plan& plan,
                                                                const runtime::Container& container);

/// A container with the components of a plan, made to be looked at: none is configured, no program is started, no socket made.
struct InertRobot {
  std::unique_ptr<runtime::Container> container;
  std::vector<LoadedComponent> loaded;
  std::vector<Finding>
      findings;  ///< Only a robot that does not run shows these: ties of components with `isolate: process`.
};
[[nodiscard]] InertRobot make_inert(const launch::Plan& plan, const loading::ProgramPlaces& places, const Clock& clock);

}  // namespace nacelle::proof
