// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/clock_skews.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/host/graph.hpp"
#include "nacelle/host/service_graph.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "transport_dds/wire/export_rules.hpp"
#include "transport_dds/wire/security_files.hpp"

namespace nacelle {

namespace transport_dds {
class RemoteGraph;
}

struct MirrorOptions {
  std::uint32_t domain_id = 0;
  std::string config;  ///< Cyclone's configuration, as ParticipantOptions::config: interfaces and peers.
  /// As in ParticipantOptions: nothing is sent to or received from other machines.
  bool stays_on_this_machine = false;
  std::string enclave = "/";                             ///< ROS 2's enclave; "/" if none is set.
  std::optional<transport_dds::SecurityFiles> security;  ///< As ParticipantOptions::security.
  std::size_t most_message_bytes = std::size_t{64}
                                   << 20U;  ///< Longer messages are refused and counted, in both directions.
  /// The topics and services that are shown and transferred. Empty: all.
  std::vector<transport_dds::ExportRule> exports;
  /// Services of this side that remote callers may not use, by full name, each with the response that they get.
  std::map<std::string, std::shared_ptr<const msgs::AnyMessage>> refused;
  /// Receives each problem of an endpoint, or mismatch of two endpoints, once. Called on the network's thread. Null:
  /// problems are logged.
  std::function<void(const Problem&)> on_problem;
  /// Receives the remote writers whose machine's clock differs from this one's (wire/peer_clock.hpp). Null: not needed.
  std::shared_ptr<ClockSkews> clock_skews;
};

/// A node of another participant with the same full name as a node of this side: ROS 2's tools confuse the two.
struct Namesake {
  std::string node;                ///< "/arm/driver"
  std::string host, process, pid;  ///< As announced by the other side; empty if it announces none (Fast DDS).
  std::string participant;         ///< Its gid.
};

/// Counters since the start, except those marked "now".
struct MirrorStats {
  std::uint64_t encoded = 0, bytes_encoded = 0;  ///< Messages of this side, each counted once for all its readers.
  std::uint64_t overtaken = 0;  ///< Not encoded, because the network could not keep up within their writer's depth.
  std::uint64_t held_back = 0;  ///< Not encoded, because they exceeded the limits of their export rule.
  std::uint64_t refused = 0;    ///< Not sent: too long, or too much in transit.
  std::uint64_t received = 0, decoded = 0;  ///< For readers of this side; one decoding serves several of them.
  std::uint64_t broken = 0;                 ///< Received, but not messages of their type.
  std::uint64_t stray = 0;      ///< From a writer that is unknown, has ended, or uses another definition of the type.
  std::uint64_t snapshots = 0;  ///< Snapshots of this side's nodes that were sent.
  std::uint64_t problems = 0;
  std::uint64_t writers = 0, readers = 0;  ///< Of this side on the network, now.
  std::uint64_t hidden = 0;  ///< Endpoints of this side that are not on the network, because no export rule names them.
  std::uint64_t taps = 0;    ///< Writers whose messages are fetched, now.
  std::uint64_t stand_ins = 0;  ///< Proxies for endpoints of other participants, now.

  // Services. Their invalid messages, and those from unknown writers, count as `broken` and `stray`.
  std::uint64_t requests = 0;          ///< From the network, passed to a server of this side.
  std::uint64_t requests_refused = 0;  ///< Too many wait, the node is inactive or gone, or the service is in `refused`.
  std::uint64_t replies = 0;           ///< Sent.
  std::uint64_t replies_dropped = 0;   ///< Their client was gone, or its reader was not discovered within 100 ms.
  std::uint64_t calls = 0;             ///< Of this side, sent.
  std::uint64_t answers = 0;           ///< To them.
  std::uint64_t calls_failed = 0;      ///< Calls that will get no answer; their clients were notified.
  std::uint64_t late = 0;              ///< Answers that arrived after their call had ended.
  std::uint64_t servers = 0, clients = 0;  ///< Of this side on the network, now.
  /// Queries to nodes of participants whose clock may be behind, and the answers; not counted as calls.
  std::uint64_t clock_questions = 0, clock_answers = 0;
};

/// Shows a graph on the network as ROS 2 nodes, and delivers the messages of other participants to it (docs/adr/0012).
///
/// Each writer and reader of the graph has its own DDS endpoint with its QoS during its whole life, whether its node is
/// active or not. A reader of a name with several types has one while its type is the announced one (Announced,
/// docs/adr/0021). Messages of a writer are fetched and encoded while a remote reader matches it; those of a
/// transient_local writer always, for late joiners. For each remote endpoint of a topic that is used here, the graph
/// gets a proxy, so that the graph's own rules check QoS and report mismatches.
///
/// A publisher never waits for the network: messages that the network cannot keep up with are overwritten within the
/// writer's depth, and counted. Services (docs/adr/0013): each server and client has two endpoints, like those of
/// rmw_cyclonedds. Servers answer remote callers while their node is active; clients of this side reach remote servers
/// while no server of this process is open. Every call ends with an answer or a notice, and the number of waiting calls
/// is bounded on either side. Not supported: remote topics without ROS's naming, and services of middlewares other than
/// rmw_cyclonedds, which use another protocol. A slow link delays large messages (16 KiB and more) but not small ones:
/// one large message of each writer is sent at a time, at a pace that leaves room for the others.
/// Threads: its own "network", and "network large" from the first large message on; all members from any thread.
class DdsMirror final {
 public:
  /// `graph`, `clock` and `services` must outlive it; without `services` there are only topics. Peers without an
  /// address are reported as problems. Errors: as Participant::create().
  [[nodiscard]] static Result<std::unique_ptr<DdsMirror>, Problem> start(Graph& graph, const Clock& clock,
                                                                         MirrorOptions options,
                                                                         ServiceGraph* services = nullptr);
  /// Tests whether start() could join: makes a participant that neither sends nor receives, and destroys it. Returns
  /// the problems that start() would report: peers without an address. Errors: as start().
  [[nodiscard]] static Result<std::vector<Problem>, Problem> try_to_join(const MirrorOptions& options);
  DdsMirror(const DdsMirror&) = delete;
  DdsMirror& operator=(const DdsMirror&) = delete;
  /// Removes all endpoints from the network.
  ~DdsMirror();

  [[nodiscard]] MirrorStats stats() const;
  /// Returns the present ones. Each was reported once.
  [[nodiscard]] std::vector<Namesake> namesakes() const;
  /// Returns the hosts whose clock differs now, each once. The log reports the start, changes, and the end.
  [[nodiscard]] std::vector<ClockSkew> clock_skews() const;
  /// Calls `look` with the nodes, topics and services of other participants. The network's thread waits meanwhile: do
  /// not use the graph from within.
  void look(const std::function<void(const transport_dds::RemoteGraph&)>& at) const;

 private:
  struct Impl;
  explicit DdsMirror(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle
