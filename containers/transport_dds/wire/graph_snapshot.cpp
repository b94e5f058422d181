// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/graph_snapshot.hpp"

#include <algorithm>

namespace nacelle::transport_dds {
namespace {

using GidMessage = ::rmw_dds_common::msg::Gid;
static_assert(sizeof(GidMessage::data) == Gid::kBytes);

}  // namespace

Gid from_message(const GidMessage& message) {
  Gid gid;
  std::copy(message.data.begin(), message.data.end(), gid.bytes.begin());
  return gid;
}

GidMessage to_message(const Gid& gid) {
  GidMessage message;
  std::copy(gid.bytes.begin(), gid.bytes.end(), message.data.begin());
  return message;
}

GraphSnapshot::GraphSnapshot(const Gid& participant) { snapshot_.gid = to_message(participant); }

void GraphSnapshot::add_node(std::string_view node_namespace, std::string_view name) {
  Node& node = snapshot_.node_entities_info_seq.emplace_back();
  node.node_namespace = node_namespace;
  node.node_name = name;
}

bool GraphSnapshot::remove_node(std::string_view node_namespace, std::string_view name) {
  Node* const node = find(node_namespace, name);
  if (node == nullptr) return false;
  auto& nodes = snapshot_.node_entities_info_seq;
  nodes.erase(nodes.begin() + (node - nodes.data()));
  return true;
}

bool GraphSnapshot::add_endpoint(std::string_view node_namespace, std::string_view name, const Gid& endpoint,
                                 bool is_writer) {
  Node* const node = find(node_namespace, name);
  if (node == nullptr) return false;
  (is_writer ? node->writer_gid_seq : node->reader_gid_seq).push_back(to_message(endpoint));
  return true;
}

bool GraphSnapshot::remove_endpoint(const Gid& endpoint, bool is_writer) {
  const GidMessage gid = to_message(endpoint);
  for (Node& node : snapshot_.node_entities_info_seq) {
    auto& gids = is_writer ? node.writer_gid_seq : node.reader_gid_seq;
    const auto found = std::find(gids.begin(), gids.end(), gid);
    if (found == gids.end()) continue;
    gids.erase(found);
    return true;
  }
  return false;
}

GraphSnapshot::Node* GraphSnapshot::find(std::string_view node_namespace, std::string_view name) {
  auto& nodes = snapshot_.node_entities_info_seq;
  const auto found = std::find_if(nodes.begin(), nodes.end(), [&](const Node& node) {
    return node.node_name == name && node.node_namespace == node_namespace;
  });
  return found == nodes.end() ? nullptr : &*found;
}

}  // namespace nacelle::transport_dds
