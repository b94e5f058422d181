// SPDX-License-Identifier: Apache-2.0
// Rules about what the plan starts: programs, plugins, parameters.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "loading/load_request.hpp"
#include "proof/rules.hpp"

namespace nacelle::proof {
namespace {

/// As posix_spawnp() will look for it: in PATH, or where the program is to work.
bool can_be_found(const process::ProgramSpec& spec) {
  if (spec.path.find('/') != std::string::npos) {
    const bool relative = spec.path.front() != '/' && !spec.working_directory.empty();
    return ::access((relative ? spec.working_directory + "/" + spec.path : spec.path).c_str(), X_OK) == 0;
  }
  const char* const path = std::getenv("PATH");
  const std::string all = path == nullptr ? "/bin:/usr/bin" : path;
  for (std::size_t begin = 0; begin <= all.size();) {
    const std::size_t end = std::min(all.find(':', begin), all.size());
    if (::access((all.substr(begin, end - begin) + "/" + spec.path).c_str(), X_OK) == 0) return true;
    begin = end + 1;
  }
  return false;
}

/// Returns where the plan gives what a problem is about: a parameter by its name, a file or a name by the value that is it.
Place place_in(const launch::ComponentPlan& plan, const Problem& problem) {
  const Place& where = problem.where;
  if (!where.parameter.empty()) return place_of_parameter(plan, where.parameter);
  for (const auto& given : plan.parameters) {
    const auto* const value = std::get_if<std::string>(&given.value);
    if (value != nullptr && !value->empty() &&
        (where.file == *value || where.words == *value || problem.value == *value))
      return given.where;
  }
  return plan.where;
}

void check_package(const LoadedComponent& component, Evidence& evidence) {
  const launch::ComponentPlan& plan = *component.plan;
  if (!component.declared || plan.package.empty() || component.declared->package.empty() ||
      plan.package == component.declared->package)
    return;
  evidence.find(
      Rule::WrongPackage,
      {plan.where, plan.full_name() + ": the class " + plan.plugin + " is not of the package '" + plan.package + "'",
       "write pkg: " + component.declared->package},
      Severity::Warning);
}

}  // namespace

Severity severity_of(const launch::ComponentPlan& plan) { return plan.required ? Severity::Error : Severity::Warning; }

Severity severity_of(const launch::Plan& plan, const std::vector<std::string>& nodes) {
  const bool optional = std::ranges::any_of(nodes, [&](const std::string& node) {
    const launch::ComponentPlan* const component = plan.find(node);
    return component != nullptr && !component->required;
  });
  return optional ? Severity::Warning : Severity::Error;
}

void check_programs(Evidence& evidence) {
  for (const auto& program : evidence.plan.programs) {
    const auto spec = loading::program_spec_of(program, evidence.places.program, evidence.places.prefixes);
    if (!spec) {
      evidence.find(Rule::NoProgram, spec.error());
    } else if (!can_be_found(spec.value())) {
      evidence.find(Rule::NoProgram,
                    {program.where, "there is no program '" + spec.value().path + "' that could be started",
                     "is it installed, and in PATH?"});
    }
  }
}

void check_components(Evidence& evidence) {
  for (const LoadedComponent& component : evidence.loaded) {
    check_parameters(component, evidence);
    check_package(component, evidence);
    // A constructor that fails on a default in place of a refused value reports only a consequence.
    if (!component.failure || has_errors(component.faults)) continue;
    const Problem& failure = *component.failure;
    evidence.find(Rule::NotMade,
                  {place_in(*component.plan, failure), failure.where.text() + ": " + failure.what, failure.way_out},
                  severity_of(*component.plan));
  }
}

void check_parameters(const LoadedComponent& component, Evidence& evidence) {
  const launch::ComponentPlan& plan = *component.plan;
  const std::string node = plan.full_name();
  for (const auto& [problem, is_warning] : component.faults) {
    const std::string& parameter = problem.where.parameter;
    std::string what = problem.what;
    if (what.ends_with('.')) what.pop_back();
    // What stands in a file that a parameter names is to be mended there.
    const bool in_file = problem.where.line > 0, named = parameter.empty() || what.find(parameter) != std::string::npos;
    if (!in_file && parameter.empty() && !problem.where.empty()) what.insert(0, problem.where.text() + ": ");
    evidence.find(
        Rule::RefusedParameter,
        {in_file ? Place{problem.where.file, problem.where.line} : place_in(plan, problem),
         fmt::format("{}: {}{}", node, named ? "" : fmt::format("parameter '{}': ", parameter), what), problem.way_out},
        is_warning ? Severity::Warning : severity_of(plan));
  }
  if (!component.declared) return;
  std::vector<std::string> known;
  for (const auto& parameter : component.declared->parameters) known.push_back(parameter.name);
  for (const auto& name : component.declared->unknown_parameters) {
    if (component.has_fault_of(name)) continue;
    if (name == "frame_prefix" && !evidence.plan.name_space.frame_prefix().empty())
      continue;  // all nodes of a launch in a namespace are given it
    const bool is_qos = name.starts_with("qos_overrides.");
    evidence.find(
        Rule::UnknownParameter,
        {place_of_parameter(plan, name), fmt::format("{} has no parameter '{}'", node, name),
         is_qos ? "a launch file's `qos:` changes the quality of service of a topic" : suggestion(name, known)},
        severity_of(plan));
  }
}

void check_sections(Evidence& evidence) {
  std::vector<std::string> nodes;
  for (const auto& component : evidence.plan.components) {
    nodes.push_back(component.full_name());
    nodes.push_back(component.name);
  }
  for (const auto& section : evidence.plan.unused_sections) {
    if (std::ranges::find(nodes, section.pattern) != nodes.end()) {
      evidence.find(Rule::UnusedSection,
                    {section.where,
                     "the parameters for '" + section.pattern + "' are not used: that node does not read this file",
                     "give it `param: [{from: FILE}]`, too"},
                    Severity::Warning);
      continue;
    }
    // Files hold sections of nodes that run elsewhere; one that is nearly a node of this plan is a slip of the pen.
    const std::string near = nearest_name(section.pattern, nodes);
    evidence.find(Rule::UnusedSection,
                  {section.where, "the parameters for '" + section.pattern + "' are not used: there is no such node",
                   near.empty() ? "leave them out, or give the node that name" : "did you mean '" + near + "'?"},
                  near.empty() ? Severity::Warning : Severity::Error);
  }
}

}  // namespace nacelle::proof
