// SPDX-License-Identifier: Apache-2.0
#include "answers/component_details.hpp"

#include <unistd.h>

#include <array>
#include <optional>

#include "answers/statistics.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/runtime/interface_messages.hpp"
#include "nacelle/runtime/parameter_messages.hpp"

namespace nacelle::answers {
namespace {

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

nacelle_interfaces::msg::ComponentLoad load_of(const runtime::LoadRequest& request, bool is_actuator) {
  nacelle_interfaces::msg::ComponentLoad load;
  for (const auto& [name, value] : request.parameters) {
    auto& parameter = load.parameters.emplace_back();
    parameter.name = name;
    parameter.value = runtime::message_of(value);
  }
  for (const auto& rule : request.remaps) load.remap_rules.push_back(to_text(rule));
  for (const auto& qos : request.qos) {
    auto& row = load.qos_overrides.emplace_back();
    row.topic = qos.topic;
    row.publisher = qos.for_publisher;
  }
  load.thread.own = request.thread.own;
  load.thread.threads = request.thread.threads;
  load.thread.priority = request.thread.priority;
  load.thread.cpus.assign(request.thread.cpus.begin(), request.thread.cpus.end());
  load.on_fault.policy = to_text(request.on_fault.policy_for(is_actuator));
  load.on_fault.max_restarts = request.on_fault.max_restarts;
  load.on_fault.backoff_s = to_seconds(request.on_fault.backoff);
  return load;
}

}  // namespace

nacelle_interfaces::srv::GetComponent::Response details_of(const runtime::Container& container,
                                                           const std::string& name) {
  nacelle_interfaces::srv::GetComponent::Response details;
  const auto found = container.find(name);
  details.success = found.has_value();
  if (!found) {
    details.problem = runtime::message_of(found.error());
    return details;
  }
  const runtime::ComponentInfo& info = found.value();
  details.container = container.node();
  details.host = host_name();
  details.component = runtime::message_of(info);
  details.actuator = info.actuator;
  for (const auto& fault : container.faults()) {
    if (fault.node == info.node) details.faults.push_back(runtime::message_of(fault));
  }
  details.callbacks = callbacks_of(container, info.node);
  details.isolated = info.isolated;
  if (const auto request = container.request_of(info.id)) details.load.push_back(load_of(*request, info.actuator));
  return details;
}

}  // namespace nacelle::answers
