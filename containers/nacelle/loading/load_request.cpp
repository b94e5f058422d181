// SPDX-License-Identifier: Apache-2.0
#include "loading/load_request.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "nacelle/base/names.hpp"

namespace nacelle::loading {
namespace {

/// The value of "--dir X" or "--dir=X".
std::string option_value(const std::vector<std::string>& words, const std::string& option) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (words[i] == option && i + 1 < words.size()) return words[i + 1];
    if (words[i].rfind(option + "=", 0) == 0) return words[i].substr(option.size() + 1);
  }
  return {};
}

}  // namespace

runtime::LoadRequest load_request_of(const launch::ComponentPlan& plan) {
  runtime::LoadRequest request;
  request.plugin = plan.plugin;
  request.name = plan.name;
  request.name_space = plan.namespace_;
  for (const auto& parameter : plan.parameters) request.parameters[parameter.name] = parameter.value;
  request.remaps = plan.remaps;
  for (const auto& qos : plan.qos) {
    request.qos.push_back({qos.topic, qos.side == launch::Side::Publisher,
                           [qos](const QoS& in_code) { return qos.applied_to(in_code); }});
  }
  request.thread = plan.thread;
  request.on_fault = plan.on_fault;
  return request;
}

std::vector<launch::Parameter> parameters_of(const runtime::LoadRequest& request) {
  std::vector<launch::Parameter> parameters;
  for (const auto& [name, value] : request.parameters) parameters.push_back({.name = name, .value = value});
  return parameters;
}

Result<process::ProgramSpec, Problem> program_spec_of(const launch::ProgramPlan& plan, const std::string& own_program,
                                                      const std::vector<std::string>& prefixes) {
  process::ProgramSpec spec;
  spec.label = plan.label;
  spec.arguments = plan.command_arguments();
  spec.environment = plan.environment;
  spec.working_directory = plan.working_directory;
  spec.required = plan.required;
  spec.sigterm_after = plan.sigterm_timeout.value_or(spec.sigterm_after);
  spec.sigkill_after = plan.sigkill_timeout.value_or(spec.sigkill_after);
  if (plan.package.empty()) {
    spec.path = plan.executable;
    return spec;
  }
  if (plan.package == "nacelle" && plan.executable == "nacelle") {
    spec.path = own_program;
    spec.arguments = plan.arguments;  // not a node, so its namespace does not matter
    const bool is_world = spec.arguments.size() >= 2 && spec.arguments[0] == "sim" && spec.arguments[1] == "world";
    if (is_world) {
      // The robot's devices exist once the world reports it.
      if (const std::string folder = option_value(spec.arguments, "--dir"); !folder.empty())
        spec.ready_file = folder + "/ready";
      spec.arguments.insert(spec.arguments.end(), {"--parent", std::to_string(::getpid())});
    }
    return spec;
  }
  std::string looked;
  for (const auto& prefix : prefixes) {
    const std::string path = prefix + "/lib/" + plan.package + "/" + plan.executable;
    if (::access(path.c_str(), X_OK) == 0) {
      spec.path = path;
      return spec;
    }
    looked += (looked.empty() ? "" : ", ") + path;
  }
  return err(Problem{
      plan.where.text(),
      "program '" + plan.executable + "' of package '" + plan.package + "' is not there (looked for " + looked + ")",
      "install it, or add its prefix to NACELLE_PREFIX_PATH"});
}

Result<runtime::ContainerOptions, std::vector<Problem>> container_options_of(
    const std::vector<launch::Parameter>& parameters, const Place& where) {
  runtime::ContainerOptions options;
  std::vector<Problem> problems;
  Place place_of_limits = where;
  for (const auto& parameter : parameters) {
    if (parameter.name == "use_sim_time") continue;  // every node of a launch file may be given it
    Duration* const limit = parameter.name == "hang_after"           ? &options.hang_after
                            : parameter.name == "handover_after"     ? &options.handover_after
                            : parameter.name == "transition_timeout" ? &options.transition_timeout
                                                                     : nullptr;
    const Place at = parameter.where.empty() ? where : parameter.where;
    if (limit == nullptr) {
      problems.push_back({at, "the container has no parameter '" + parameter.name + "'",
                          suggestion(parameter.name, {"hang_after", "handover_after", "transition_timeout"})});
      continue;
    }
    double seconds = 0;
    if (const auto* const real = std::get_if<double>(&parameter.value)) seconds = *real;
    if (const auto* const whole = std::get_if<std::int64_t>(&parameter.value)) seconds = static_cast<double>(*whole);
    if (!(seconds >= 0.001 && seconds <= 3600)) {
      problems.push_back({at,
                          fmt::format("parameter '{}' of the container must be seconds from 0.001 to 3600, not {}",
                                      parameter.name, nacelle::to_text(parameter.value)),
                          "leave it out for the default"});
      continue;
    }
    *limit = from_seconds(seconds);
    if (limit != &options.transition_timeout) place_of_limits = at;
  }
  // A refused limit's default would be compared: a consequence.
  if (problems.empty() && options.hang_after <= options.handover_after) {
    problems.push_back(
        {place_of_limits,
         "hang_after of the container must be longer than handover_after, or no callback could be late without hanging",
         "the defaults are 1.5 and 0.02"});
  }
  if (!problems.empty()) return err(std::move(problems));
  return options;
}

}  // namespace nacelle::loading
