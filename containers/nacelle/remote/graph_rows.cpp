// SPDX-License-Identifier: Apache-2.0
#include "remote/graph_rows.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "nacelle/host/standard_interfaces.hpp"
#include "requests/qos_json.hpp"

namespace nacelle::remote {
namespace {

using nlohmann::json;
using transport_dds::RemoteEndpoint;
using transport_dds::RemoteGraph;
using transport_dds::WireKind;

/// As ros2 prints an identifier.
std::string dotted(const transport_dds::Gid& gid) {
  const std::string digits = gid.text();
  std::string text;
  for (std::size_t i = 0; i < digits.size(); i += 2) text += (i == 0 ? "" : ".") + digits.substr(i, 2);
  return text;
}

/// The last eight bytes: a participant's own number of the endpoint, with a part of its own.
std::uint64_t number_of(const transport_dds::Gid& gid) {
  std::uint64_t number = 0;
  for (std::size_t i = transport_dds::Gid::kBytes - 8; i < transport_dds::Gid::kBytes; ++i)
    number = number << 8U | gid.bytes[i];
  return number;
}

/// Behind the node's name, in the node's name.
bool is_standard_service(const std::string& node, const std::string& service) {
  const auto names = standard_services(node, true);
  return std::ranges::find(names, service) != names.end();
}

json endpoint_row(const RemoteEndpoint& end) {
  return {{"topic", end.name},
          {"type", end.type},
          {"hash", end.user_data.type_hash},
          {"node", full_name(end.node_namespace, end.node_name)},
          {"id", number_of(end.gid)},
          {"gid", dotted(end.gid)},
          {"publisher", end.is_writer},
          {"standard", is_standard_topic(end.name)},
          {"elsewhere", false},
          {"qos", requests::json_of(end.qos)}};
}

/// Of its four ends two read: the server's of requests, the client's of replies.
json service_rows(const RemoteGraph& graph) {
  json rows = json::array();
  for (const auto& [name, types] : graph.services()) {
    for (const RemoteEndpoint& end : graph.ends_of_service(name)) {
      if (end.is_writer) continue;
      const std::string node = full_name(end.node_namespace, end.node_name);
      rows.push_back({{"name", name},
                      {"type", transport_dds::service_of_half(end.type).value_or(end.type)},
                      {"node", node},
                      {"server", end.kind == WireKind::Request},
                      {"open", true},
                      {"standard", is_standard_service(node, name)}});
    }
  }
  return rows;
}

}  // namespace

std::string full_name(const std::string& node_namespace, const std::string& name) {
  return node_namespace == "/" ? "/" + name : node_namespace + "/" + name;
}

json graph_rows(const RemoteGraph& graph) {
  json services = service_rows(graph);
  std::set<std::string> offered;
  for (const auto& row : services) {
    if (row["server"].get<bool>()) offered.insert(row["name"].get<std::string>());
  }
  json nodes = json::array(), endpoints = json::array();
  for (const auto& node : graph.nodes()) {
    const std::string name = full_name(node.node_namespace, node.name);
    nodes.push_back({{"node", name},
                     {"id", 0},
                     {"managed", offered.contains(name + "/get_state")},
                     {"state", ""},
                     {"plugin", ""},
                     {"isolated", false},
                     {"hidden", name.find("/_") != std::string::npos},
                     {"parameters", offered.contains(name + "/list_parameters")},
                     {"host", node.host},
                     {"pid", node.pid}});
  }
  for (const auto& [topic, types] : graph.topics()) {
    for (const RemoteEndpoint& end : graph.ends_of_topic(topic)) endpoints.push_back(endpoint_row(end));
  }
  return {{"ok", true}, {"nodes", nodes}, {"endpoints", endpoints}, {"services", std::move(services)}};
}

json topic_rows(const RemoteGraph& graph) {
  json rows = json::array();
  for (const auto& [topic, types] : graph.topics()) {
    std::map<std::string, std::pair<std::size_t, std::size_t>> ends;
    for (const RemoteEndpoint& end : graph.ends_of_topic(topic))
      ++(end.is_writer ? ends[end.type].first : ends[end.type].second);
    for (const auto& [type, count] : ends)
      rows.push_back({{"name", topic}, {"type", type}, {"writers", count.first}, {"readers", count.second}});
  }
  return rows;
}

}  // namespace nacelle::remote
