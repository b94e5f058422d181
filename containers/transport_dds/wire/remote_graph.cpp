// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/remote_graph.hpp"

#include <algorithm>

#include "nacelle/base/names.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle::transport_dds {
namespace {

// A name that is not ROS 2's may contain any bytes, and is shown nevertheless.
std::string printable(std::string_view text) {
  std::string shown(text.substr(0, kMaxDdsNameBytes));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return shown;
}

std::size_t gids_in(const Snapshot& snapshot) {
  std::size_t sum = 0;
  for (const auto& node : snapshot.node_entities_info_seq)
    sum += node.reader_gid_seq.size() + node.writer_gid_seq.size();
  return sum;
}

}  // namespace

RemoteGraph::RemoteGraph(const Gid& own, const RemoteGraphLimits& limits) : own_(own.participant()), limits_(limits) {}

void RemoteGraph::participant_is_there(const DiscoveredParticipant& told) {
  if (told.gid == own_) return;
  if (!told.gid.is_participant()) {
    ++stats_.foreign_endpoints;
    return;
  }
  Participant* const entry = entry_of(told.gid);
  if (entry == nullptr) return;
  entry->is_discovered = true;
  entry->enclave = read_participant_user_data(told.user_data);
  if (entry->enclave) entry->enclave = printable(*entry->enclave);
  entry->host = printable(told.host);
  entry->process = printable(told.process);
  entry->pid = printable(told.pid);
  ++version_;
}

void RemoteGraph::participant_has_gone(const Gid& gone) {
  if (participants_.erase(gone) == 0) return;
  // Gids sort by their prefix: the participant's endpoints stand side by side.
  Gid first = gone;
  std::fill(first.bytes.begin() + Gid::kPrefixBytes, first.bytes.end(), std::uint8_t{0});
  auto at = endpoints_.lower_bound(first);
  while (at != endpoints_.end() && at->first.same_participant(gone)) at = endpoints_.erase(at);
  ++version_;
}

void RemoteGraph::endpoint_is_there(const DiscoveredEndpoint& told) {
  if (told.participant == own_) return;
  if (told.participant != told.gid.participant() || told.gid.is_participant()) {
    ++stats_.foreign_endpoints;
    return;
  }
  RosName name = ros_name(told.topic);
  if (name.kind == WireKind::Foreign || name.kind == WireKind::Discovery) {
    const auto its = participants_.find(told.participant);
    if (its != participants_.end()) its->second.has_endpoints_told = true;
    return;
  }
  Participant* const entry = entry_of(told.participant);
  if (entry == nullptr) return;
  entry->has_endpoints_told = true;

  const auto known = endpoints_.find(told.gid);
  if (known == endpoints_.end()) {
    if (endpoints_.size() >= limits_.endpoints || entry->endpoints >= limits_.endpoints_of_one) {
      ++stats_.too_many_endpoints;
      forget_if_empty(told.participant);
      return;
    }
    ++entry->endpoints;
  }
  auto type = ros_type_name(told.type);
  Endpoint endpoint{told.is_writer, std::move(name), type ? std::move(*type) : printable(told.type),
                    read_endpoint_user_data(told.user_data), from_dds(told.qos)};
  if (known != endpoints_.end() && known->second == endpoint) return;
  endpoints_.insert_or_assign(told.gid, std::move(endpoint));
  ++version_;
}

void RemoteGraph::endpoint_has_gone(const Gid& gone) {
  if (endpoints_.erase(gone) == 0) return;
  --participants_.at(gone.participant()).endpoints;
  forget_if_empty(gone.participant());
  ++version_;
}

void RemoteGraph::snapshot_came(const Gid& writer, ByteView payload) {
  if (writer.participant() == own_) return;
  if (payload.size() > limits_.snapshot_bytes) {
    ++stats_.too_many_nodes;
    return;
  }
  Snapshot snapshot;
  if (!msgs::from_cdr(payload, snapshot)) {
    ++stats_.broken_snapshots;
    return;
  }
  const Gid participant = from_message(snapshot.gid);
  if (participant != writer.participant()) {
    ++stats_.foreign_snapshots;
    return;
  }
  if (!has_room_for(participant, snapshot)) {
    ++stats_.too_many_nodes;
    return;
  }
  Participant* const entry = entry_of(participant);
  if (entry == nullptr) return;
  auto nodes = checked_nodes(participant, snapshot);
  if (nodes != entry->nodes) ++version_;
  entry->nodes = std::move(nodes);
  forget_if_empty(participant);
}

RemoteGraph::Participant* RemoteGraph::entry_of(const Gid& gid) {
  const auto known = participants_.find(gid);
  if (known != participants_.end()) return &known->second;
  if (participants_.size() >= limits_.participants) {
    ++stats_.too_many_participants;
    return nullptr;
  }
  return &participants_[gid];
}

void RemoteGraph::forget_if_empty(const Gid& gid) {
  const auto known = participants_.find(gid);
  if (known != participants_.end() && known->second.holds_nothing()) participants_.erase(known);
}

bool RemoteGraph::awaits_endpoints() const {
  return std::ranges::any_of(
      participants_, [](const auto& entry) { return entry.second.is_discovered && !entry.second.has_endpoints_told; });
}

bool RemoteGraph::has_room_for(const Gid& participant, const Snapshot& snapshot) const {
  std::size_t nodes = snapshot.node_entities_info_seq.size(), gids = gids_in(snapshot);
  if (nodes > limits_.nodes_of_one) return false;
  for (const auto& [gid, other] : participants_) {
    if (gid == participant) continue;
    nodes += other.nodes.size();
    for (const Node& node : other.nodes) gids += node.readers.size() + node.writers.size();
  }
  return nodes <= limits_.nodes && gids <= limits_.gids;
}

std::vector<RemoteGraph::Node> RemoteGraph::checked_nodes(const Gid& participant, const Snapshot& snapshot) {
  const auto own_gids = [&](const auto& messages) {
    std::vector<Gid> gids;
    for (const auto& message : messages) {
      const Gid gid = from_message(message);
      if (gid.same_participant(participant)) gids.push_back(gid);
      if (!gid.same_participant(participant)) ++stats_.foreign_endpoints;
    }
    std::sort(gids.begin(), gids.end());
    return gids;
  };
  std::vector<Node> nodes;
  for (const auto& told : snapshot.node_entities_info_seq) {
    if (!validate_node_name(told.node_name) || !validate_namespace(told.node_namespace)) {
      ++stats_.bad_nodes;
      continue;
    }
    nodes.push_back(
        {told.node_namespace, told.node_name, own_gids(told.reader_gid_seq), own_gids(told.writer_gid_seq)});
  }
  return nodes;
}

}  // namespace nacelle::transport_dds
