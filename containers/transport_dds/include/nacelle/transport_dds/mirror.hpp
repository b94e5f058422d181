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
  std::string config;  ///< Cyclone's, as ParticipantOptions::config: which interfaces, which peers.
  /// As ParticipantOptions: nothing leaves this machine, and nothing from elsewhere is heard.
  bool stays_on_this_machine = false;
  std::string enclave = "/";                                ///< ROS 2's; without an own one it is "/".
  std::optional<transport_dds::SecurityFiles> security;     ///< As ParticipantOptions::security.
  std::size_t most_message_bytes = std::size_t{64} << 20U;  ///< Longer ones are refused and counted, both ways.
  /// Ends of other topics and services are not shown, and nothing of them goes either way. Empty: all are.
  std::vector<transport_dds::ExportRule> exports;
  /// Services of this side that callers outside may not use, by full name, each with the response that they get.
  std::map<std::string, std::shared_ptr<const msgs::AnyMessage>> refused;
  /// What keeps an endpoint from the network, or two of them apart, each once. On the network's thread. Null: the log.
  std::function<void(const Problem&)> on_problem;
  /// Filled with the remote writers whose machine's clock differs from ours (wire/peer_clock.hpp). Null: nobody asks.
  std::shared_ptr<ClockSkews> clock_skews;
};

/// A node of another participant with the full name of one of this side: ROS 2's tools confuse them.
struct Namesake {
  std::string node;                ///< "/arm/driver"
  std::string host, process, pid;  ///< As the other side says; empty: it does not (Fast DDS).
  std::string participant;         ///< Its gid.
};

/// Since the start, but for those that say "now".
struct MirrorStats {
  std::uint64_t encoded = 0, bytes_encoded = 0;  ///< Messages of this side, once each for all that read them.
  std::uint64_t overtaken = 0;                   ///< Never encoded: the network was slower than their writer's depth.
  std::uint64_t held_back = 0;                   ///< Not encoded: more than their rule of export lets through.
  std::uint64_t refused = 0;                     ///< Not sent: too long, or more on its way than may be.
  std::uint64_t received = 0, decoded = 0;       ///< For readers of this side; one decoding serves several of them.
  std::uint64_t broken = 0;                      ///< Were no messages of their type.
  std::uint64_t stray = 0;                       ///< From a writer that is unknown, gone, or has another definition.
  std::uint64_t snapshots = 0;                   ///< Of the own nodes, sent.
  std::uint64_t problems = 0;
  std::uint64_t writers = 0, readers = 0;  ///< Of this side on the network, now.
  std::uint64_t hidden = 0;                ///< Of this side and not on the network, since no rule of export names them.
  std::uint64_t taps = 0;                  ///< Writers whose messages are fetched, now.
  std::uint64_t stand_ins = 0;             ///< For ends of other participants, now.

  // Services. What of them is no message, or comes from a stranger, counts as `broken` and `stray`.
  std::uint64_t requests = 0;              ///< From outside, handed to a server of this side.
  std::uint64_t requests_refused = 0;      ///< Too many wait, the node is not active or has gone, or it is `refused`.
  std::uint64_t replies = 0;               ///< Sent.
  std::uint64_t replies_dropped = 0;       ///< Their client had gone, or its reader did not come within 100 ms.
  std::uint64_t calls = 0;                 ///< Of this side, sent.
  std::uint64_t answers = 0;               ///< To them.
  std::uint64_t calls_failed = 0;          ///< Calls that will get no answer; their clients know.
  std::uint64_t late = 0;                  ///< Answers that came after their call had ended.
  std::uint64_t servers = 0, clients = 0;  ///< Of this side on the network, now.
  /// To nodes of participants whose clock may be behind, and their answers: no calls of this side.
  std::uint64_t clock_questions = 0, clock_answers = 0;
};

/// Shows a graph on the network as ROS 2 nodes, and brings in what other participants publish (docs/adr/0012).
///
/// Each writer and reader of the graph has a DDS endpoint of its own with its QoS, from when it is made to its end, whether
/// its node is active or not; a reader of one of several types has it while its type is the one to show (Announced,
/// docs/adr/0021). Messages of a writer are fetched and encoded while somebody on the network has matched it;
/// those of a transient_local writer always, for who comes late. For each remote end of a topic with a use here the graph
/// gets a stand-in, so that the graph's own rules judge QoS and tell what happens.
///
/// A publisher never waits for the network: what that cannot follow is overwritten within the writer's depth, and counted.
/// Services (docs/adr/0013): each server and client has its two endpoints, as rmw_cyclonedds makes them. Callers outside are
/// answered by servers whose node is active; clients of this side reach servers outside while none of this process is open.
/// A client is always told in the end, and no more than a bounded number of calls waits on either side.
/// Not over the network: topics that avoid ROS's naming towards this side, and services of other middlewares than
/// rmw_cyclonedds, which have another protocol.
/// A slow wire holds up large messages (16 KiB and more), and then the small ones go on: one of each writer at a time is sent,
/// at a pace that leaves room for the others.
/// Threads: its own "network", and "network large" from the first large message on; all members from any thread.
class DdsMirror final {
 public:
  /// `graph`, `clock` and `services` must outlive it; without `services` there are only topics. Peers without an address are
  /// told as problems. Errors: as
  /// Participant::create().
  [[nodiscard]] static Result<std::unique_ptr<DdsMirror>, Problem> start(Graph& graph, const Clock& clock,
                                                                         MirrorOptions options,
                                                                         ServiceGraph* services = nullptr);
  /// Whether start() could join: makes the participant, which says nothing and hears nobody, and ends it. What it would
  /// remark on: peers without an address. Errors: as start().
  [[nodiscard]] static Result<std::vector<Problem>, Problem> try_to_join(const MirrorOptions& options);
  DdsMirror(const DdsMirror&) = delete;
  DdsMirror& operator=(const DdsMirror&) = delete;
  /// All leave the network.
  ~DdsMirror();

  [[nodiscard]] MirrorStats stats() const;
  /// Now. Each was told once.
  [[nodiscard]] std::vector<Namesake> namesakes() const;
  /// The hosts whose clock differs now, each once. They are told in the log when it begins, changes, or ends.
  [[nodiscard]] std::vector<ClockSkew> clock_skews() const;
  /// Nodes, topics and services of other participants. The network's thread waits meanwhile: do not use the graph from
  /// within.
  void look(const std::function<void(const transport_dds::RemoteGraph&)>& at) const;

 private:
  struct Impl;
  explicit DdsMirror(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle
