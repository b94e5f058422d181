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
  std::optional<Problem> failure;                         ///< Why it could not be constructed.
  std::shared_ptr<const runtime::Declarations> declared;  ///< Null if it was not constructed.
  std::vector<ParameterFault> faults;                     ///< Refused values.

  [[nodiscard]] bool has_fault_of(std::string_view parameter) const;
};

/// Returns the findings for a plan whose components were constructed and not configured: parameters, plugins, types and
/// QoS of every pair, remaps, frames, budgets, programs, conditions. `nacelle check` and a launch before its activation
/// use the same rules.
///
/// A finding that concerns only a component with `required: false` is a warning, because the launch continues without
/// it.
/// Threads: any, while no component is being loaded.
[[nodiscard]] std::vector<Finding> prove(const launch::Plan& plan, const loading::ProgramPlaces& places,
                                         runtime::Container& container, const std::vector<LoadedComponent>& loaded);

/// Returns the place where the plan sets the component's parameter; otherwise the component's own place.
[[nodiscard]] Place place_of_parameter(const launch::ComponentPlan& plan, const std::string& parameter);

/// Returns the budgets with their topics. A budget without a topic covers every topic that its component publishes.
[[nodiscard]] std::vector<runtime::StreamBudget> stream_budgets(const launch::Plan& plan,
                                                                const runtime::Container& container);

/// A container with the components of a plan, for checks only: no component is configured, no program is started, no
/// socket is created.
struct InertRobot {
  std::unique_ptr<runtime::Container> container;
  std::vector<LoadedComponent> loaded;
  std::vector<Finding> findings;  ///< Ties of components with `isolate: process`, and copies between processes.
};
[[nodiscard]] InertRobot make_inert(const launch::Plan& plan, const loading::ProgramPlaces& places, const Clock& clock);

}  // namespace nacelle::proof
