// SPDX-License-Identifier: Apache-2.0
// Queries of the graph of other processes. remote_graph.cpp fills it.
#include <algorithm>
#include <iterator>

#include "transport_dds/wire/remote_graph.hpp"
#include "transport_dds/wire/service_call.hpp"

namespace nacelle::transport_dds {
namespace {

bool is_of_service(WireKind kind) { return kind == WireKind::Request || kind == WireKind::Reply; }

std::string service_of(const std::string& half) { return service_of_half(half).value_or(half); }

}  // namespace

std::vector<RemoteNode> RemoteGraph::nodes() const {
  std::vector<RemoteNode> all;
  for (const auto& [gid, participant] : participants_) {
    if (!participant.enclave) continue;
    for (const Node& node : participant.nodes) {
      all.push_back({node.node_namespace, node.name, *participant.enclave, participant.host, participant.process,
                     participant.pid, gid});
    }
  }
  return all;
}

std::optional<RemoteNodeInfo> RemoteGraph::node(std::string_view node_namespace, std::string_view name) const {
  const Node* found = nullptr;
  for (const auto& [gid, participant] : participants_) {
    if (!participant.enclave) continue;
    for (const Node& node : participant.nodes) {
      if (found == nullptr && node.name == name && node.node_namespace == node_namespace) found = &node;
    }
  }
  if (found == nullptr) return std::nullopt;
  RemoteNodeInfo info;
  for (const auto& gid : found->writers) {
    const auto at = endpoints_.find(gid);
    if (at == endpoints_.end() || !at->second.is_writer) continue;
    const auto& [kind, topic] = at->second.name;
    if (kind == WireKind::Topic) info.publishers[topic].insert(at->second.type);
  }
  for (const auto& gid : found->readers) {
    const auto at = endpoints_.find(gid);
    if (at == endpoints_.end() || at->second.is_writer) continue;
    const auto& [kind, topic] = at->second.name;
    if (kind == WireKind::Topic) info.subscriptions[topic].insert(at->second.type);
    if (kind == WireKind::Request) info.servers[topic].insert(service_of(at->second.type));
    if (kind == WireKind::Reply) info.clients[topic].insert(service_of(at->second.type));
  }
  return info;
}

NamesAndTypes RemoteGraph::topics() const {
  NamesAndTypes all;
  for (const auto& [gid, endpoint] : endpoints_) {
    if (endpoint.name.kind == WireKind::Topic) all[endpoint.name.name].insert(endpoint.type);
  }
  return all;
}

NamesAndTypes RemoteGraph::services() const {
  NamesAndTypes all;
  for (const auto& [gid, endpoint] : endpoints_) {
    if (is_of_service(endpoint.name.kind)) all[endpoint.name.name].insert(service_of(endpoint.type));
  }
  return all;
}

std::vector<RemoteEndpoint> RemoteGraph::ends_of_topic(std::string_view name) const {
  return ends_of(name, [](WireKind kind) { return kind == WireKind::Topic; });
}

std::vector<RemoteEndpoint> RemoteGraph::ends_of_service(std::string_view name) const {
  return ends_of(name, is_of_service);
}

std::optional<RemoteEndpoint> RemoteGraph::endpoint(const Gid& gid) const {
  const auto at = endpoints_.find(gid);
  if (at == endpoints_.end()) return std::nullopt;
  return described(gid, at->second);
}

template <typename Select>
std::vector<RemoteEndpoint> RemoteGraph::ends_of(std::string_view name, Select select) const {
  std::vector<RemoteEndpoint> ends;
  for (const auto& [gid, endpoint] : endpoints_) {
    if (select(endpoint.name.kind) && endpoint.name.name == name) ends.push_back(described(gid, endpoint));
  }
  return ends;
}

std::vector<std::string> RemoteGraph::services_of(const Gid& participant, std::string_view type,
                                                  std::string_view request_hash) const {
  Gid first = participant;
  std::fill(first.bytes.begin() + Gid::kPrefixBytes, first.bytes.end(), std::uint8_t{0});
  std::set<std::string> asked, answered;
  for (auto at = endpoints_.lower_bound(first); at != endpoints_.end() && at->first.same_participant(first); ++at) {
    const Endpoint& end = at->second;
    if (service_of(end.type) != type || has_other_protocol(end.user_data)) continue;
    const std::string& hash = end.user_data.type_hash;
    if (end.name.kind == WireKind::Request && !end.is_writer && (hash.empty() || hash == request_hash))
      asked.insert(end.name.name);
    if (end.name.kind == WireKind::Reply && end.is_writer) answered.insert(end.name.name);
  }
  std::vector<std::string> names;
  std::ranges::set_intersection(asked, answered, std::back_inserter(names));
  return names;
}

std::string RemoteGraph::host_of(const Gid& participant) const {
  const auto found = participants_.find(participant);
  return found == participants_.end() ? std::string{} : found->second.host;
}

RemoteEndpoint RemoteGraph::described(const Gid& gid, const Endpoint& endpoint) const {
  const Node* const node = node_of(gid, endpoint.is_writer);
  return {gid,
          endpoint.is_writer,
          node == nullptr ? std::string(kUnknownNodeNamespace) : node->node_namespace,
          node == nullptr ? std::string(kUnknownNodeName) : node->name,
          endpoint.name.kind,
          endpoint.name.name,
          endpoint.type,
          endpoint.user_data,
          endpoint.qos};
}

const RemoteGraph::Node* RemoteGraph::node_of(const Gid& endpoint, bool is_writer) const {
  const auto at = participants_.find(endpoint.participant());
  if (at == participants_.end()) return nullptr;
  for (const Node& node : at->second.nodes) {
    const auto& gids = is_writer ? node.writers : node.readers;
    if (std::binary_search(gids.begin(), gids.end(), endpoint)) return &node;
  }
  return nullptr;
}

}  // namespace nacelle::transport_dds
