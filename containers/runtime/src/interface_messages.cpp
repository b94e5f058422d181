// SPDX-License-Identifier: Apache-2.0
#include "nacelle/runtime/interface_messages.hpp"

namespace nacelle::runtime {

nacelle_interfaces::msg::Problem message_of(const Problem& problem) {
  nacelle_interfaces::msg::Problem message;
  message.where = problem.where.text();
  message.what = problem.what;
  message.way_out = problem.way_out;
  message.code = problem.code.text();
  return message;
}

nacelle_interfaces::msg::Fault message_of(const FaultReason& fault) {
  nacelle_interfaces::msg::Fault message;
  message.code = fault.code;
  message.text = fault.text;
  return message;
}

nacelle_interfaces::msg::FaultEvent message_of(const FaultEvent& event) {
  nacelle_interfaces::msg::FaultEvent message;
  message.number = event.number;
  message.node = event.node;
  message.code = event.code;
  message.text = event.text;
  message.callback = event.callback;
  message.time_ns = event.when.nanoseconds();
  message.is_open_fault = event.is_open_fault;
  if (event.lasted) message.lasted_s.push_back(to_seconds(*event.lasted));
  return message;
}

lifecycle_msgs::msg::State message_of(StateId state) {
  lifecycle_msgs::msg::State message;
  message.id = static_cast<std::uint8_t>(state);
  message.label = to_text(state);
  return message;
}

nacelle_interfaces::msg::Component message_of(const ComponentInfo& info) {
  nacelle_interfaces::msg::Component message;
  message.id = info.id;
  message.node = info.node;
  message.plugin = info.plugin;
  message.library = info.library;
  message.managed = info.managed;
  if (info.managed) message.state = message_of(info.state);
  if (!info.fault.code.empty()) message.fault.push_back(message_of(info.fault));
  for (const auto& fault : info.open_faults) message.open_faults.push_back(message_of(fault));
  for (const auto& node : info.other_nodes) message.other_nodes.push_back(node);
  return message;
}

}  // namespace nacelle::runtime
