// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/bytes.hpp"
#include "nacelle/qos/qos.hpp"
#include "transport_dds/wire/discovered.hpp"
#include "transport_dds/wire/graph_snapshot.hpp"
#include "transport_dds/wire/names.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle::transport_dds {

/// Limits of the cache, because any program on the network can announce anything. Entries beyond a limit are refused
/// and counted until they are announced again.
struct RemoteGraphLimits {
  std::size_t participants = 256;
  std::size_t endpoints = 16384;        ///< Of all participants together.
  std::size_t endpoints_of_one = 2048;  ///< Of one participant, so that it cannot crowd out the others.
  std::size_t nodes = 4096;             ///< In all snapshots together.
  std::size_t nodes_of_one = 256;       ///< In one snapshot.
  std::size_t gids = 32768;             ///< Of endpoints in all snapshots together.
  std::size_t snapshot_bytes = 262144;  ///< Of one encoded snapshot.
};

/// Entries that the cache has refused since it was made.
struct RemoteGraphStats {
  std::uint64_t too_many_participants = 0;
  std::uint64_t too_many_endpoints = 0;
  std::uint64_t too_many_nodes = 0;     ///< Snapshots with too many nodes, gids or bytes.
  std::uint64_t broken_snapshots = 0;   ///< Samples that cannot be decoded.
  std::uint64_t foreign_snapshots = 0;  ///< Snapshots about another participant than their sender.
  std::uint64_t foreign_endpoints = 0;  ///< Endpoints, and gids in snapshots, of another participant than the sender.
  std::uint64_t bad_nodes = 0;          ///< Nodes with names that ROS 2 does not allow.
  friend bool operator==(const RemoteGraphStats&, const RemoteGraphStats&) = default;
};

struct RemoteNode {
  std::string node_namespace;  ///< "/" or "/arm"
  std::string name;
  std::string enclave;
  std::string host, process, pid;  ///< As its participant announces them; may be empty.
  Gid participant;
};

/// Names ("/chatter"), each with the types in use under it; more than one type is a configuration mistake.
using NamesAndTypes = std::map<std::string, std::set<std::string>, std::less<>>;

struct RemoteNodeInfo {
  NamesAndTypes publishers, subscriptions, servers, clients;
};

inline constexpr std::string_view kUnknownNodeName = "_NODE_NAME_UNKNOWN_";
inline constexpr std::string_view kUnknownNodeNamespace = "_NODE_NAMESPACE_UNKNOWN_";

struct RemoteEndpoint {
  Gid gid;
  bool is_writer = false;
  std::string node_namespace, node_name;  ///< kUnknownNode... if no snapshot contains it: not a node, or not known yet.
  /// Topic, Request or Reply. The reader of a Request belongs to a server, its writer to a client.
  WireKind kind = WireKind::Topic;
  std::string name;  ///< ROS 2's name of the topic or service.
  std::string type;  ///< ROS 2's name of the type; DDS's name if it is not a type of ROS 2.
  EndpointUserData user_data;
  QoS qos{1};
};

/// A cache of the nodes, topics and services of other processes, as ROS 2's tools show them, fed by DDS's discovery.
///
/// Announcements are hostile. They are checked and bounded, and the answers are safe to show on a terminal. They may
/// arrive in any order. The nodes of a participant are those of its last snapshot; they are listed once the participant
/// is known to be one of ROS 2. Endpoints without a name in ROS 2 are ignored.
/// Threads: one at a time. Source: graph_cache.cpp of rmw_dds_common, rmw_node.cpp of rmw_cyclonedds_cpp (jazzy).
class RemoteGraph {
 public:
  /// `own` is this process's participant; its announcements are ignored.
  explicit RemoteGraph(const Gid& own, const RemoteGraphLimits& limits = {});

  void participant_is_there(const DiscoveredParticipant& told);
  void participant_has_gone(const Gid& gone);  ///< With its nodes and endpoints.
  void endpoint_is_there(const DiscoveredEndpoint& told);
  void endpoint_has_gone(const Gid& gone);
  /// Takes a sample of ros_discovery_info, with its encapsulation, and the gid of its writer.
  void snapshot_came(const Gid& writer, ByteView payload);

  /// Returns the nodes for `ros2 node list`: one entry for each, also for those with equal names.
  [[nodiscard]] std::vector<RemoteNode> nodes() const;
  /// Returns the endpoints of a node for `ros2 node info`; nothing if there is no such node. Of several nodes with this
  /// name, uses the first.
  [[nodiscard]] std::optional<RemoteNodeInfo> node(std::string_view node_namespace, std::string_view name) const;
  [[nodiscard]] NamesAndTypes topics() const;
  /// Returns the services, also those with clients only, as rmw does.
  [[nodiscard]] NamesAndTypes services() const;
  /// Returns all endpoints of a topic, or of both topics of a service, ordered by gid.
  [[nodiscard]] std::vector<RemoteEndpoint> ends_of_topic(std::string_view name) const;
  [[nodiscard]] std::vector<RemoteEndpoint> ends_of_service(std::string_view name) const;
  /// Returns the endpoint with this gid, of a topic or a service; nothing if it is unknown.
  [[nodiscard]] std::optional<RemoteEndpoint> endpoint(const Gid& gid) const;

  /// Returns the services of this type ("rcl_interfaces/srv/GetParameterTypes") that the participant serves and that
  /// can be called from here: both of the server's endpoints are known, with the protocol of rmw_cyclonedds, and the
  /// definition of the request does not differ from `request_hash`.
  [[nodiscard]] std::vector<std::string> services_of(const Gid& participant, std::string_view type,
                                                     std::string_view request_hash) const;
  /// Returns whether a discovered participant has not announced its endpoints yet.
  [[nodiscard]] bool awaits_endpoints() const;
  /// Returns the host that the participant announces; empty if it announces none, or is unknown.
  [[nodiscard]] std::string host_of(const Gid& participant) const;

  /// Returns a number that grows with every change of an answer above.
  [[nodiscard]] std::uint64_t version() const { return version_; }
  [[nodiscard]] const RemoteGraphStats& stats() const { return stats_; }

 private:
  struct Node {
    std::string node_namespace, name;
    std::vector<Gid> readers, writers;  ///< Sorted.
    friend bool operator==(const Node&, const Node&) = default;
  };
  struct Participant {
    std::optional<std::string> enclave;  ///< Nothing: not a participant of ROS 2, or not discovered yet.
    std::string host, process, pid;
    std::vector<Node> nodes;
    std::size_t endpoints = 0;
    [[nodiscard]] bool holds_nothing() const { return !is_discovered && nodes.empty() && endpoints == 0; }
    bool is_discovered = false;
    bool has_endpoints_told = false;  ///< Endpoints with any name, ROS 2's or not.
  };
  struct Endpoint {
    bool is_writer = false;
    RosName name;
    std::string type;
    EndpointUserData user_data;
    QoS qos{1};
    friend bool operator==(const Endpoint&, const Endpoint&) = default;
  };

  [[nodiscard]] Participant* entry_of(const Gid& gid);
  void forget_if_empty(const Gid& gid);
  [[nodiscard]] std::vector<Node> checked_nodes(const Gid& participant, const Snapshot& snapshot);
  [[nodiscard]] bool has_room_for(const Gid& participant, const Snapshot& snapshot) const;
  [[nodiscard]] const Node* node_of(const Gid& endpoint, bool is_writer) const;
  [[nodiscard]] RemoteEndpoint described(const Gid& gid, const Endpoint& endpoint) const;
  template <typename Select>
  [[nodiscard]] std::vector<RemoteEndpoint> ends_of(std::string_view name, Select select) const;

  Gid own_;
  RemoteGraphLimits limits_;
  RemoteGraphStats stats_;
  std::uint64_t version_ = 0;
  std::map<Gid, Participant> participants_;
  std::map<Gid, Endpoint> endpoints_;
};

}  // namespace nacelle::transport_dds
