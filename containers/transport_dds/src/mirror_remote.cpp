// SPDX-License-Identifier: Apache-2.0
// Remote endpoints: what discovery reports about them, and their proxies.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <map>

#include "mirror_impl.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

// A peer may announce any number of endpoints, and each proxy has a pool or a queue.
constexpr std::size_t kMostStandIns = 4096;

// Unlike those of a broker (its pid times 2^40) these have the highest bit set.
std::uint64_t id_of(std::uint32_t link, std::uint64_t count) {
  return std::uint64_t{1} << 63U | (static_cast<std::uint64_t>(::getpid()) & 0x3FFFFFU) << 40U |
         static_cast<std::uint64_t>(link & 0xFFU) << 32U | (count & 0xFFFFFFFFU);
}

std::string full_name(const std::string& node_namespace, const std::string& name) {
  return (node_namespace == "/" ? "" : node_namespace) + "/" + name;
}

std::string this_program() {
  std::array<char, HOST_NAME_MAX + 1> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host.front() = '?';
  return std::string("process ") + std::to_string(::getpid()) + " (" + program_invocation_short_name + ") on " +
         host.data();
}

std::string program_of(const Namesake& other) {
  std::string text = other.pid.empty() ? "participant " + other.participant : "process " + other.pid;
  if (!other.process.empty()) text += " (" + other.process + ")";
  return text + " on " + (other.host.empty() ? "an unnamed host" : other.host);
}

/// Limits the depth of a proxy's QoS, which is shown but has no queue behind it.
QoS within_reason(QoS qos) {
  constexpr std::size_t kDeepest = 1000;
  return qos.keeps_all() ? qos.max_samples(std::min(qos.max_samples(), kDeepest))
                         : qos.keep_last(std::min(qos.depth(), kDeepest));
}

template <typename End>
const msgs::MessageType* type_among(const std::vector<End*>& ends, const std::string& name) {
  const auto found = std::ranges::find_if(ends, [&](const End* end) { return name == end->info.spec.type->name; });
  return found == ends.end() ? nullptr : (*found)->info.spec.type;
}

Duration manual_lease_of(const dds::RemoteEndpoint& end) {
  return end.qos.liveliness() == Liveliness::ManualByTopic ? end.qos.liveliness_lease_duration() : Duration::zero();
}

}  // namespace

void DdsMirror::Impl::take_discovery() {
  for (bool more = true; more;) {
    found_now.clear();
    more = discovery->take(found_now, 256);
    for (const auto& event : found_now) {
      if (const auto* const found = std::get_if<dds::DiscoveredParticipant>(&event.what)) {
        take_participant(event.kind, *found);
      } else {
        take_endpoint(event.kind, std::get<dds::DiscoveredEndpoint>(event.what));
      }
    }
  }
}

void DdsMirror::Impl::take_participant(dds::DiscoveryEvent::Kind kind, const dds::DiscoveredParticipant& found) {
  if (kind != dds::DiscoveryEvent::Kind::Gone) return remote.lock()->participant_is_there(found);
  are_types_new = true;
  remote.lock()->participant_has_gone(found.gid);
  gone_now.insert(found.gid);
}

void DdsMirror::Impl::take_endpoint(dds::DiscoveryEvent::Kind kind, const dds::DiscoveredEndpoint& found) {
  are_types_new = true;
  if (kind == dds::DiscoveryEvent::Kind::Gone) {
    remote.lock()->endpoint_has_gone(found.gid);
    gone_now.insert(found.gid);
    return;
  }
  remote.lock()->endpoint_is_there(found);
  const auto end = remote.lock()->endpoint(found.gid);
  if (!end) return;
  gone_now.erase(end->gid);
  consider(*end);
}

void DdsMirror::Impl::take_snapshots() {
  while (const auto sample = snapshot_reader->take())
    remote.lock()->snapshot_came(sample->writer, sample->payload.bytes());
  if (!nameless.empty()) misfits_due = clock.now();
}

// --- names ---------------------------------------------------------------------------------------------------------------

void DdsMirror::Impl::look_for_namesakes() {
  std::set<std::string> ours;
  for (const auto& node : own_nodes.message().node_entities_info_seq)
    ours.insert(full_name(node.node_namespace, node.node_name));
  std::vector<Namesake> found;
  if (!ours.empty()) {
    for (const auto& node : remote.lock()->nodes()) {
      std::string name = full_name(node.node_namespace, node.name);
      if (ours.contains(name))
        found.push_back({std::move(name), node.host, node.process, node.pid, node.participant.text()});
    }
  }
  // A second robot has the names of all: one line for each other program.
  std::map<std::string, std::vector<std::string>> names_of;
  for (const Namesake& one : found) names_of[one.participant].push_back(one.node);
  for (const Namesake& one : found) {
    std::vector<std::string>& names = names_of[one.participant];
    if (names.empty()) continue;
    tell_once("nodes of " + one.participant,
              {join(names),
               (names.size() == 1 ? "two nodes of this name are on the network: one here, "
                                  : "two nodes of each of these names are on the network: one here, ") +
                   this_program() + ", and one in " + program_of(one) + ": tools confuse them",
               "put one program into a namespace (namespace:=NAME), or into another ROS_DOMAIN_ID; `nacelle doctor "
               "net` lists them"});
    names.clear();
  }
  *namesakes.lock() = std::move(found);
}

// --- stand-ins -------------------------------------------------------------------------------------------------------

void DdsMirror::Impl::consider_all(const std::string& topic) {
  const auto ends = remote.lock()->ends_of_topic(topic);
  for (const auto& end : ends) consider(end);
}

std::string DdsMirror::Impl::node_name_of(const dds::RemoteEndpoint& end) {
  if (end.node_name == dds::kUnknownNodeName) return "participant " + end.gid.participant().text();
  return (end.node_namespace == "/" ? "" : end.node_namespace) + "/" + end.node_name;
}

std::string DdsMirror::Impl::node_of(const dds::Gid& endpoint) const {
  const auto known = remote.lock()->endpoint(endpoint);
  return known ? node_name_of(*known) : "participant " + endpoint.participant().text();
}

// Makes, keeps or destroys the proxy, depending on whether this side uses it now.
void DdsMirror::Impl::consider(const dds::RemoteEndpoint& end) {
  if (end.kind != dds::WireKind::Topic) return;
  const auto found = topics.find(end.name);
  const TopicUse* const use = found == topics.end() ? nullptr : &found->second;
  const auto known = stand_ins.find(end.gid);
  const msgs::MessageType* type = nullptr;
  if (use != nullptr) type = end.is_writer ? type_among(use->readers, end.type) : type_among(use->writers, end.type);
  if (known != stand_ins.end()) {
    if (type == known->second.type && end.qos == known->second.end.qos) return;
    forget(end.gid);
  }
  if (type == nullptr) {
    if (!those_with_other_types(end).empty()) wait_in(other_types, end.gid);
    return;
  }
  if (waits_for_name(end, *use, *type)) return;
  if (!those_that_do_not_serve(end).empty()) wait_in(unserved, end.gid);
  if (fits(end, *type)) make_stand_in(end, *type);
}

void DdsMirror::Impl::make_stand_in(const dds::RemoteEndpoint& end, const msgs::MessageType& type) {
  if (stand_ins.size() >= kMostStandIns)
    return tell_once("full", {end.name,
                              "more than " + std::to_string(kMostStandIns) +
                                  " ends of other participants on the topics of this side: the others are left out",
                              "use another domain, or name the peers"});
  StandIn& made = stand_ins[end.gid];
  made.end = end;
  made.type = &type;
  made.id = id_of(number, ++next_stand_in);
  EndpointSpec spec;
  spec.topic = end.name;
  spec.type = &type;
  spec.qos = within_reason(end.qos);
  spec.node = node_name_of(end);
  spec.via = number;
  if (end.is_writer) {
    made.writer = graph.create_proxy_writer(spec, made.id);
    made.peer = &peer_of(end);
    if (made.peer->clock.ahead() != Duration::zero()) publish_skews();
    if (manual_lease_of(end) > Duration::zero()) manual.insert(end.gid);
  } else {
    made.witness = graph.create_witness(spec);
    for (const LocalWriter* writer : topics.at(end.name).writers) {
      if (writer->matched.contains(end.gid)) made.witness->count_for(writer->info.id, true);
    }
  }
  stand_in_count = stand_ins.size();
}

void DdsMirror::Impl::drop_gone() {
  if (gone_now.empty()) return;
  for (auto& [name, use] : topics) {
    while (receive(use)) {}
  }
  for (const auto& gone : gone_now) {
    forget(gone);
    awaited.erase(gone);
    if (!gone.is_participant()) continue;
    std::erase_if(awaited, [&](const dds::Gid& gid) { return gid.same_participant(gone); });
    std::vector<dds::Gid> its;
    for (const auto& [gid, stand_in] : stand_ins) {
      if (gid.same_participant(gone)) its.push_back(gid);
    }
    for (const auto& gid : its) forget(gid);
    if (const auto peer = peers.extract(gone); peer && peer.mapped().clock.ahead() != Duration::zero()) {
      told_skews.erase(peer.mapped().host);  // reported again if it returns
      publish_skews();
    }
  }
  gone_now.clear();
}

void DdsMirror::Impl::forget(const dds::Gid& gid) {
  if (stand_ins.erase(gid) != 0) stand_in_count = stand_ins.size();
  manual.erase(gid);
  std::erase_if(misfits, [&](const auto& pair) { return pair.first == gid; });
  std::erase_if(handles, [&](const auto& entry) { return entry.second == gid; });
  for (const auto& [id, reader] : readers) reader->sequences.erase(gid);
}

// A writer may assert its liveliness without a message. DDS reports only when that stops and when it resumes. As long as it has
// not stopped, the stand-in asserts its own.
MonotonicTime DdsMirror::Impl::show_life() {
  MonotonicTime due = kNeverExpires;
  for (const auto& gid : manual) {
    StandIn& stand_in = stand_ins.at(gid);
    const Duration lease = manual_lease_of(stand_in.end);
    const auto topic = topics.find(stand_in.end.name);
    if (topic == topics.end()) continue;
    const auto& ours = topic->second.readers;
    const bool all_alive = std::ranges::all_of(
        ours, [](const LocalReader* reader) { return !reader->reader || reader->reader->status().not_alive == 0; });
    const MonotonicTime at = clock.now();
    if (all_alive && at - stand_in.showed_life >= lease / 2) {
      stand_in.showed_life = at;
      stand_in.writer->assert_liveliness();
    }
    if (all_alive) due = std::min(due, stand_in.showed_life + lease / 2);
  }
  return due;
}

}  // namespace nacelle
