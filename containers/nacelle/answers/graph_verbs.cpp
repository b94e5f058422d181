// SPDX-License-Identifier: Apache-2.0
#include "answers/graph_verbs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "nacelle/host/standard_interfaces.hpp"
#include "requests/qos_json.hpp"

namespace nacelle::answers {
namespace {

using nlohmann::json;

json to_json(const runtime::EndpointReport& end) {
  json row{{"topic", end.topic},
           {"type", end.type},
           {"hash", end.type_hash},
           {"node", end.node},
           {"id", end.id},
           {"publisher", end.is_writer},
           {"standard", is_standard_topic(end.topic)},
           {"elsewhere", end.in_other_process},
           {"qos", requests::json_of(end.qos)}};
  if (end.command_timeout.after > Duration::zero()) {
    row["command_timeout_s"] = to_seconds(end.command_timeout.after);
    row["command_parameter"] = end.command_timeout.parameter;
  }
  return row;
}

json node_row(const runtime::ComponentInfo& info) {
  return {{"node", info.node},       {"id", info.id},
          {"managed", info.managed}, {"state", info.managed ? nacelle::to_text(info.state) : ""},
          {"plugin", info.plugin},   {"isolated", info.isolated},
          {"hidden", false}};
}

/// A node that is no component: the container's own, one beside a component, or a tool's.
json other_row(const std::string& node, bool hidden) {
  return {{"node", node}, {"id", 0},           {"managed", false}, {"state", ""},
          {"plugin", ""}, {"isolated", false}, {"hidden", hidden}};
}

}  // namespace

json graph_of(Robot& robot) {
  const runtime::Container& container = robot.container();
  std::set<std::string> known;
  json nodes = json::array(), endpoints = json::array(), services = json::array();
  for (const auto& info : container.list()) {
    nodes.push_back(node_row(info));
    known.insert(info.node);
    for (const auto& other : info.other_nodes) {
      nodes.push_back(other_row(other, false));
      known.insert(other);
    }
  }
  const auto note = [&](const std::string& node, bool hidden) {
    if (known.insert(node).second) nodes.push_back(other_row(node, hidden));
  };
  for (const auto& service : container.services()) {
    note(service.node, !service.name.starts_with(service.node + "/_container/"));
    services.push_back({{"name", service.name},
                        {"type", service.type},
                        {"node", service.node},
                        {"server", service.is_server},
                        {"open", service.open},
                        {"standard", service.is_standard}});
  }
  for (const auto& end : container.endpoints()) {
    note(end.node, true);
    endpoints.push_back(to_json(end));
  }
  return {
      {"ok", true}, {"container", robot.name()}, {"nodes", nodes}, {"endpoints", endpoints}, {"services", services}};
}

}  // namespace nacelle::answers
