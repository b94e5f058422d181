// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "loading/wiring.hpp"
#include "proof/declared_graph.hpp"
#include "proof/proof.hpp"

namespace nacelle::proof {

/// The input of the rules, and their findings. Each rule is a function; proof.cpp calls them.
struct Evidence {
  const launch::Plan& plan;
  const loading::ProgramPlaces& places;
  runtime::Container& container;
  const std::vector<LoadedComponent>& loaded;
  const std::vector<Endpoint> endpoints;
  std::vector<Finding> findings{};

  void find(Rule rule, Problem problem, Severity severity = Severity::Error) {
    problem.code = rule;
    findings.push_back({severity, std::move(problem)});
  }
  [[nodiscard]] loading::TopicEnds ends_of(const LoadedComponent& component) const;
};

/// Returns the services that the container will offer for a component's node, as for every node.
[[nodiscard]] std::vector<std::string> standard_services_of(const Evidence& evidence, const LoadedComponent& component);
/// Returns Warning for a component that is not required, because a launch continues without it.
[[nodiscard]] Severity severity_of(const launch::ComponentPlan& plan);
/// Returns Warning if one of several nodes is optional.
[[nodiscard]] Severity severity_of(const launch::Plan& plan, const std::vector<std::string>& nodes);
/// Returns the severity for a budget, which is identified by its place.
[[nodiscard]] Severity severity_of_budget(const launch::Plan& plan, const Place& where);

// components.cpp
void check_programs(Evidence& evidence);
void check_components(Evidence& evidence);
void check_parameters(const LoadedComponent& component, Evidence& evidence);
void check_sections(Evidence& evidence);
// streams.cpp
void check_pairs(Evidence& evidence);
void check_topics(Evidence& evidence);
void check_budgets(Evidence& evidence);
// feeds.cpp
void check_subscriptions(Evidence& evidence);
void check_clients(Evidence& evidence);
void check_exports(Evidence& evidence);
// hardware.cpp
void check_devices(Evidence& evidence);
void check_wheels(Evidence& evidence);
// headings.cpp
void check_headings(Evidence& evidence);
// order.cpp
void check_order(Evidence& evidence);
// frames.cpp
void check_frames(Evidence& evidence);

}  // namespace nacelle::proof
