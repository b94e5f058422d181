// SPDX-License-Identifier: Apache-2.0
#include "proof/proof.hpp"

#include <set>

#include "loading/load_request.hpp"
#include "nacelle/host/standard_interfaces.hpp"
#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

/// Finds ties of an isolated component to components of its own process, without starting that process.
std::optional<Problem> tied(const launch::ComponentPlan& plan, const loading::ProgramPlaces& places,
                            const Clock& clock) {
  runtime::ContainerOptions options;
  options.name = "check";
  options.component_path = places.component_folders;
  runtime::Container alone{std::move(options), clock};
  auto request = loading::load_request_of(plan);
  request.faults = std::make_shared<ParameterFaults>();
  if (!alone.load(request)) return std::nullopt;  // the actual load reports it
  const auto ties = alone.ties();
  if (ties.empty()) return std::nullopt;
  return Problem{plan.where,
                 plan.full_name() + " cannot be isolated: it " + join(ties, ", it ") + ", which ends at its process",
                 "leave isolate: process out", Rule::NotIsolated};
}

/// Each message is copied once for every node of another process; here all nodes are in one, so it is counted from the plan.
std::vector<Finding> copies_between_processes(const launch::Plan& plan, runtime::Container& container) {
  const auto process_of = [&](const std::string& node) {
    const launch::ComponentPlan* const component = plan.find(node);
    return component != nullptr && component->isolate == launch::Isolation::Process ? node : std::string{};
  };
  const std::vector<Endpoint> endpoints = endpoints_of(container.graph());
  std::vector<Finding> findings;
  for (const auto& budget : stream_budgets(plan, container)) {
    if (!budget.max_copies) continue;
    std::set<std::string> apart;
    for (const auto& writer : endpoints) {
      if (writer.topic != budget.topic || !writer.publishes) continue;
      for (const auto& reader : endpoints) {
        if (reader.topic == budget.topic && !reader.publishes && process_of(reader.node) != process_of(writer.node))
          apart.insert(reader.node);
      }
    }
    const std::uint64_t here = container.wiring(budget.topic, Duration::max()).copies;
    if (here > *budget.max_copies || here + apart.size() <= *budget.max_copies)
      continue;  // reported without isolation, or met
    findings.push_back(
        {severity_of_budget(plan, budget.where),
         {budget.where,
          "max_copies " + std::to_string(*budget.max_copies) + " of " + budget.topic +
              " cannot be kept: between processes each message is copied for " + join({apart.begin(), apart.end()}),
          "leave `isolate: process` out, or allow the copies", Rule::Budget}});
  }
  return findings;
}

}  // namespace

bool LoadedComponent::has_fault_of(std::string_view parameter) const {
  return std::ranges::any_of(faults,
                             [&](const ParameterFault& fault) { return fault.problem.where.parameter == parameter; });
}

Place place_of_parameter(const launch::ComponentPlan& plan, const std::string& parameter) {
  for (const auto& given : plan.parameters) {
    if (given.name == parameter) return given.where;
  }
  return plan.where;
}

std::vector<std::string> standard_services_of(const Evidence& evidence, const LoadedComponent& component) {
  const auto found = evidence.container.find(component.plan->full_name());
  return standard_services(component.plan->full_name(), !found || found.value().managed);
}

loading::TopicEnds Evidence::ends_of(const LoadedComponent& component) const {
  loading::TopicEnds ends;
  const std::string node = component.plan->full_name();
  for (const auto& endpoint : endpoints) {
    if (endpoint.node == node) (endpoint.publishes ? ends.published : ends.subscribed).insert(endpoint.topic);
  }
  if (component.declared)
    ends.services.insert(component.declared->services.begin(), component.declared->services.end());
  return ends;
}

std::vector<Finding> prove(const launch::Plan& plan, const loading::ProgramPlaces& places,
                           runtime::Container& container, const std::vector<LoadedComponent>& loaded) {
  Evidence evidence{plan, places, container, loaded, endpoints_of(container.graph())};
  if (plan.components.empty() && plan.programs.empty() && !plan.container.declared) {
    evidence.find(Rule::NothingToStart,
                  {plan.file, "there is nothing to start",
                   "it needs a node_container with composable_node, a node or an executable (is an `if` false?)"});
  }
  const auto options = loading::container_options_of(plan.container.parameters, plan.container.where);
  if (!options) {
    for (const auto& problem : options.error()) evidence.find(Rule::RefusedParameter, problem);
  }
  check_programs(evidence);
  check_components(evidence);
  check_sections(evidence);
  check_pairs(evidence);
  check_topics(evidence);
  check_subscriptions(evidence);
  check_clients(evidence);
  check_exports(evidence);
  check_budgets(evidence);
  check_devices(evidence);
  check_wheels(evidence);
  check_headings(evidence);
  check_frames(evidence);
  check_order(evidence);
  return std::move(evidence.findings);
}

InertRobot make_inert(const launch::Plan& plan, const loading::ProgramPlaces& places, const Clock& clock) {
  InertRobot robot;
  runtime::ContainerOptions options;
  options.name = plan.container.name.empty() ? "check" : plan.container.name;
  options.component_path = places.component_folders;
  robot.container = std::make_unique<runtime::Container>(std::move(options), clock);
  for (const auto& component : plan.components) {
    auto request = loading::load_request_of(component);
    request.thread = {};  // no callback will run: one thread does
    request.faults = std::make_shared<ParameterFaults>();
    const auto made = robot.container->load(request);
    LoadedComponent& entry = robot.loaded.emplace_back();
    entry.plan = &component;
    if (made) entry.declared = made.value().declared;
    if (!made) entry.failure = made.error();
    entry.faults = *request.faults->lock();
    if (component.isolate != launch::Isolation::Process) continue;
    if (auto problem = tied(component, places, clock))
      robot.findings.push_back({component.required ? Severity::Error : Severity::Warning, *problem});
  }
  auto copies = copies_between_processes(plan, *robot.container);
  robot.findings.insert(robot.findings.end(), copies.begin(), copies.end());
  return robot;
}

}  // namespace nacelle::proof
