// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <rmw_dds_common/msg/participant_entities_info.hpp>
#include <string>
#include <string_view>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/wire/gid.hpp"

namespace nacelle::transport_dds {

/// rmw_dds_common/msg/ParticipantEntitiesInfo, the message of ros_discovery_info: all nodes of a participant, each with
/// the gids of its readers and writers. A server or a client has a reader and a writer.
using Snapshot = ::rmw_dds_common::msg::ParticipantEntitiesInfo;

[[nodiscard]] Gid from_message(const ::rmw_dds_common::msg::Gid& message);
[[nodiscard]] ::rmw_dds_common::msg::Gid to_message(const Gid& gid);

/// Maintains the snapshot of this participant. After a change the whole snapshot must be sent again.
///
/// Nodes and gids are in the order in which they were added, as with rmw. If several nodes have the same name, the
/// functions use the first one.
/// Threads: one at a time. Source: context.cpp, graph_cache.cpp of rmw_dds_common (jazzy).
class GraphSnapshot {
 public:
  explicit GraphSnapshot(const Gid& participant);

  void add_node(std::string_view node_namespace, std::string_view name);
  /// Removes a node and its remaining endpoints. Returns false if there is no such node.
  bool remove_node(std::string_view node_namespace, std::string_view name);
  /// Returns false, and adds nothing, if there is no such node.
  bool add_endpoint(std::string_view node_namespace, std::string_view name, const Gid& endpoint, bool is_writer);
  /// Removes an endpoint from the node that has it. Returns false if there is none.
  bool remove_endpoint(const Gid& endpoint, bool is_writer);

  [[nodiscard]] const Snapshot& message() const { return snapshot_; }

 private:
  using Node = ::rmw_dds_common::msg::NodeEntitiesInfo;
  [[nodiscard]] Node* find(std::string_view node_namespace, std::string_view name);
  Snapshot snapshot_;
};

}  // namespace nacelle::transport_dds
