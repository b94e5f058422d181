// SPDX-License-Identifier: Apache-2.0
#include "composition_answers.hpp"

#include <stdexcept>

#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/log.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/runtime/container.hpp"
#include "nacelle/runtime/interface_messages.hpp"
#include "nacelle/runtime/parameter_messages.hpp"

namespace nacelle::runtime {
namespace {

using composition_interfaces::srv::ListNodes;
using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;
using nacelle_interfaces::srv::ChangeState;
using nacelle_interfaces::srv::GetComponents;
using nacelle_interfaces::srv::LoadComponent;
using nacelle_interfaces::srv::UnloadComponent;

// For LoadNode and LoadComponent, whose fields have the same names. Errors: std::invalid_argument with a text for the
// caller.
template <typename Request>
LoadRequest request_of(const Request& asked, const std::string& plugin) {
  LoadRequest wanted;
  wanted.plugin = plugin;
  wanted.name = asked.node_name;
  wanted.name_space = asked.node_namespace;
  for (const auto& text : asked.remap_rules) {
    auto rule = parse_remap_rule(text);
    if (!rule) throw std::invalid_argument("remap rule '" + text + "': " + rule.error().text());
    wanted.remaps.push_back(std::move(rule).value());
  }
  for (const auto& parameter : asked.parameters)
    wanted.parameters[parameter.name] = value_of(parameter.name, parameter.value);
  return wanted;
}

void check_extra_arguments(const LoadNode::Request& asked) {
  for (const auto& argument : asked.extra_arguments) {
    const bool known = argument.name == "use_intra_process_comms" || argument.name == "forward_global_arguments";
    if (known && !std::holds_alternative<bool>(value_of(argument.name, argument.value)))
      throw std::invalid_argument("Extra component argument '" + argument.name + "' must be a boolean");
  }
}

void log_kept_image(std::uint64_t id, const UnloadOutcome& outcome) {
  if (outcome.image_closed) return;
  Logger{"container"}.info("component {} is unloaded, its image is kept, held by {}", id, outcome.held_by);
}

}  // namespace

void answer(Composed& composed, const LoadNode::Request& request, LoadNode::Response& response) {
  check_extra_arguments(request);
  const auto loaded = composed.host.load(request_of(request, request.plugin_name), false);
  response.success = static_cast<bool>(loaded);
  if (!loaded) {
    response.error_message = loaded.error().text();
    return;
  }
  for (const std::string& warning : loaded.value().warnings) Logger{"container"}.warn("{}", warning);
  response.full_node_name = loaded.value().component.node;
  response.unique_id = loaded.value().component.id;
}

void answer(Composed& composed, const UnloadNode::Request& request, UnloadNode::Response& response) {
  if (!composed.container.find(std::to_string(request.unique_id))) {
    response.error_message = "No node found with unique_id: " + std::to_string(request.unique_id);
    return;
  }
  const auto outcome = composed.host.unload(request.unique_id);
  response.success = static_cast<bool>(outcome);
  if (outcome) {
    log_kept_image(request.unique_id, outcome.value());
  } else {
    response.error_message = outcome.error().text();
  }
}

void answer(Composed& composed, const ListNodes::Request&, ListNodes::Response& response) {
  for (const auto& component : composed.container.list()) {
    response.full_node_names.push_back(component.node);
    response.unique_ids.push_back(component.id);
  }
}

void answer(Composed& composed, const GetComponents::Request&, GetComponents::Response& response) {
  response.container = composed.container.node();
  response.name_space = composed.host.name_space();
  for (const auto& component : composed.container.list()) response.components.push_back(message_of(component));
  for (const auto& image : composed.container.kept_images()) {
    auto& kept = response.kept_images.emplace_back();
    kept.node = image.node;
    kept.plugin = image.plugin;
    kept.library = image.library;
    kept.held_by = image.held_by;
  }
}

void answer(Composed& composed, const LoadComponent::Request& request, LoadComponent::Response& response) {
  const bool is_class = request.component.find("::") != std::string::npos;
  const auto loaded = is_class ? composed.host.load(request_of(request, request.component), true)
                               : composed.host.load_planned(request.component);
  response.success = static_cast<bool>(loaded);
  if (!loaded) {
    response.problem = message_of(loaded.error());
    return;
  }
  const auto& [component, warnings] = loaded.value();
  response.component = message_of(component);
  for (const auto* const texts : {&component.warnings, &warnings}) {
    for (const std::string& text : *texts) response.warnings.push_back(text);
  }
}

void answer(Composed& composed, const UnloadComponent::Request& request, UnloadComponent::Response& response) {
  const auto component = composed.container.find(request.component);
  const auto outcome =
      component ? composed.host.unload(component.value().id) : Result<UnloadOutcome, Problem>{err(component.error())};
  response.success = static_cast<bool>(outcome);
  if (!outcome) {
    response.problem = message_of(outcome.error());
    return;
  }
  response.id = component.value().id;
  response.node = component.value().node;
  response.library = component.value().library;
  response.image_closed = outcome.value().image_closed;
  response.held_by = outcome.value().held_by;
}

void answer(Container& container, const ChangeState::Request& request, ChangeState::Response& response) {
  const auto component = container.find(request.component);
  if (!component) {
    response.problem = message_of(component.error());
    return;
  }
  response.node = component.value().node;
  Transition transition{};
  if (!parse_transition(request.transition, transition)) {
    response.problem = message_of(
        Problem{"transition '" + request.transition + "'", "there is no such transition",
                suggestion(request.transition, {"configure", "activate", "deactivate", "cleanup", "shutdown"}),
                LifecycleFault::NoSuchTransition, request.transition});
    return;
  }
  const TransitionOutcome outcome = container.trigger(component.value().id, transition);
  response.success = outcome.success;
  response.state = message_of(outcome.state);
  if (!outcome.success)
    response.problem =
        message_of(Problem{response.node, std::string{"could not "} + to_text(transition) + ": " + outcome.reason,
                           std::string{"it is "} + to_text(outcome.state) + " now", LifecycleFault::TransitionFailed,
                           to_text(transition)});
}

}  // namespace nacelle::runtime
