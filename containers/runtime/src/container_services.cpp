// SPDX-License-Identifier: Apache-2.0
#include "container_services.hpp"

#include <cctype>
#include <composition_interfaces/srv/list_nodes.hpp>
#include <composition_interfaces/srv/load_node.hpp>
#include <composition_interfaces/srv/unload_node.hpp>
#include <stdexcept>

#include "nacelle/base/log.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/runtime/container.hpp"
#include "parameter_messages.hpp"

namespace nacelle::runtime {
namespace {

using composition_interfaces::srv::ListNodes;
using composition_interfaces::srv::LoadNode;
using composition_interfaces::srv::UnloadNode;

NodeIdentity identity_of(std::string name, const std::string& name_space) {
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0) name.insert(0, "container_");
  return {std::move(name), name_space};
}

// Errors: std::invalid_argument in words for the caller.
LoadRequest request_of(const LoadNode::Request& asked) {
  LoadRequest wanted;
  wanted.plugin = asked.plugin_name;
  wanted.name = asked.node_name;
  wanted.name_space = asked.node_namespace;
  for (const auto& text : asked.remap_rules) {
    auto rule = parse_remap_rule(text);
    if (!rule) throw std::invalid_argument("remap rule '" + text + "': " + rule.error().text());
    wanted.remaps.push_back(std::move(rule).value());
  }
  for (const auto& parameter : asked.parameters)
    wanted.parameters[parameter.name] = value_of(parameter.name, parameter.value);
  for (const auto& argument : asked.extra_arguments) {
    const bool known = argument.name == "use_intra_process_comms" || argument.name == "forward_global_arguments";
    if (known && !std::holds_alternative<bool>(value_of(argument.name, argument.value)))
      throw std::invalid_argument("Extra component argument '" + argument.name + "' must be a boolean");
  }
  return wanted;
}

void answer(Container& container, const LoadNode::Request& request, LoadNode::Response& response) {
  response = {};
  try {
    const auto loaded = container.load(request_of(request));
    response.success = static_cast<bool>(loaded);
    if (!loaded) {
      response.error_message = loaded.error().text();
      return;
    }
    response.full_node_name = loaded.value().node;
    response.unique_id = loaded.value().id;
  } catch (const std::invalid_argument& e) { response.error_message = e.what(); }
}

void answer(Container& container, const UnloadNode::Request& request, UnloadNode::Response& response) {
  response = {};
  const auto outcome = container.unload(request.unique_id);
  response.success = static_cast<bool>(outcome);
  if (!outcome) {
    response.error_message = "No node found with unique_id: " + std::to_string(request.unique_id);
  } else if (!outcome.value().image_closed) {
    Logger{"container"}.info("component {} is unloaded, its image is kept, held by {}", request.unique_id,
                             outcome.value().held_by);
  }
}

void answer(Container& container, const ListNodes::Request&, ListNodes::Response& response) {
  response = {};
  for (const auto& component : container.list()) {
    response.full_node_names.push_back(component.node);
    response.unique_ids.push_back(component.id);
  }
}

}  // namespace

template <typename S>
bool ContainerServices::run(void* container, std::int64_t, const void* request, void* response) {
  answer(*static_cast<Container*>(container), *static_cast<const typename S::Request*>(request),
         *static_cast<typename S::Response*>(response));
  return true;
}

ContainerServices::ContainerServices(Container& container, Commons& commons, const std::string& name,
                                     const std::string& name_space)
    : executor_("container", commons.clock, {.own = true}),
      node_(
          commons, identity_of(name, name_space), executor_,
          [](const std::string& code, const std::string& text, const std::string& callback) {
            Logger{"container"}.error("{}: {} (in {})", code, text, callback);
          },
          false) {
  const std::string prefix = node_.identity().fully_qualified() + "/_container/";
  const auto offer = [&]<typename S>(const char* what, std::in_place_type_t<S>) {
    return node_.create_service(prefix + what, S::Request::message_type(), S::Response::message_type(),
                                {&ContainerServices::run<S>, &container}, nullptr);
  };
  load_ = offer("load_node", std::in_place_type<LoadNode>);
  unload_ = offer("unload_node", std::in_place_type<UnloadNode>);
  list_ = offer("list_nodes", std::in_place_type<ListNodes>);
  node_.open();
}

ContainerServices::~ContainerServices() = default;

}  // namespace nacelle::runtime
