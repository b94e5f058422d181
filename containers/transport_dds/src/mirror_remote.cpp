// SPDX-License-Identifier: Apache-2.0
// The ends of other participants: what discovery tells of them, and their stand-ins.
#include <unistd.h>

#include <algorithm>

#include "mirror_impl.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/qos/compatibility.hpp"

namespace nacelle {
namespace {

// A peer may announce what it likes; each stand-in has a pool or a queue.
constexpr std::size_t kMostStandIns = 4096;
// For the name of its node, which is announced behind an endpoint; what is no node of ROS 2 has none.
constexpr Duration kLongestNameless = 1s;

// Unlike those of a broker (its pid times 2^40) these have the highest bit set.
std::uint64_t id_of(std::uint32_t link, std::uint64_t count) {
  return std::uint64_t{1} << 63U | (static_cast<std::uint64_t>(::getpid()) & 0x3FFFFFU) << 40U |
         static_cast<std::uint64_t>(link & 0xFFU) << 32U | (count & 0xFFFFFFFFU);
}

std::string node_name_of(const dds::RemoteEndpoint& end) {
  if (end.node_name == dds::kUnknownNodeName) return "participant " + end.gid.participant().text();
  return (end.node_namespace == "/" ? "" : end.node_namespace) + "/" + end.node_name;
}

/// What a stand-in's queue would take is nobody's business but its depth is shown.
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

template <typename End>
std::set<std::string> types_of(const std::vector<End*>& ends) {
  std::set<std::string> names;
  for (const End* end : ends) names.insert(end->info.spec.type->name);
  return names;
}

template <typename End>
bool would_match(const std::vector<End*>& ours, const dds::RemoteEndpoint& end, const msgs::MessageType& type) {
  return std::ranges::any_of(ours, [&](const End* own) {
    if (own->info.spec.type != &type) return false;
    const QoS qos = own->info.spec.qos.resolved();
    return (end.is_writer ? verdict_of(end.qos, qos) : verdict_of(qos, end.qos)) != Verdict::Error;
  });
}

// ROS 2's middlewares match by name and read nonsense; a peer without a hash is believed.
bool is_same_definition(const dds::RemoteEndpoint& end, const msgs::MessageType& type) {
  return end.user_data.type_hash.empty() || end.user_data.type_hash == type.hash;
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
  remote.lock()->participant_has_gone(found.gid);
  gone_now.insert(found.gid);
}

void DdsMirror::Impl::take_endpoint(dds::DiscoveryEvent::Kind kind, const dds::DiscoveredEndpoint& found) {
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
}

// --- stand-ins -------------------------------------------------------------------------------------------------------

void DdsMirror::Impl::consider_all(const std::string& topic) {
  const auto ends = remote.lock()->ends_of_topic(topic);
  for (const auto& end : ends) consider(end);
}

std::string DdsMirror::Impl::node_of(const dds::Gid& endpoint) const {
  const auto known = remote.lock()->endpoint(endpoint);
  return known ? node_name_of(*known) : "participant " + endpoint.participant().text();
}

// Makes, keeps or drops the stand-in, as this side has a use for it now.
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
  if (use == nullptr || (end.is_writer ? use->readers.empty() : use->writers.empty())) {
    nameless.erase(end.gid);
    return;
  }
  if (waits_for_name(end, *use, type)) return;
  if (type == nullptr) {
    const auto ours = end.is_writer ? types_of(use->readers) : types_of(use->writers);
    return tell_once(end.name + " " + end.type + " " + end.gid.participant().text() + (end.is_writer ? " w" : " r"),
                     {end.name,
                      node_name_of(end) + (end.is_writer ? " publishes " : " reads ") + end.type + ", this side has " +
                          join({ours.begin(), ours.end()}) + ": they do not hear each other",
                      "rename one of the topics with a remap, or make both sides use one type"});
  }
  if (fits(end, *type)) make_stand_in(end, *type);
}

bool DdsMirror::Impl::waits_for_name(const dds::RemoteEndpoint& end, const TopicUse& use,
                                     const msgs::MessageType* type) {
  const auto fitting = [&] {
    if (type == nullptr || !is_same_definition(end, *type)) return false;
    return end.is_writer ? would_match(use.readers, end, *type) : would_match(use.writers, end, *type);
  };
  if (end.node_name == dds::kUnknownNodeName && !fitting()) {
    const MonotonicTime since = nameless.try_emplace(end.gid, clock.now()).first->second;
    if (clock.now() - since < kLongestNameless) return true;
  }
  nameless.erase(end.gid);
  return false;
}

MonotonicTime DdsMirror::Impl::consider_nameless() {
  MonotonicTime due = kNeverExpires;
  for (auto next = nameless.begin(); next != nameless.end();) {
    const auto [gid, since] = *next++;
    const auto end = remote.lock()->endpoint(gid);
    if (!end) {
      nameless.erase(gid);
    } else if (end->node_name != dds::kUnknownNodeName || clock.now() - since >= kLongestNameless) {
      consider(*end);
    } else {
      due = std::min(due, since + kLongestNameless);
    }
  }
  return due;
}

bool DdsMirror::Impl::fits(const dds::RemoteEndpoint& end, const msgs::MessageType& type) {
  if (is_same_definition(end, type)) return true;
  tell_once(end.name + " " + end.user_data.type_hash,
            {end.name,
             node_name_of(end) + " has " + end.type + " as " + end.user_data.type_hash + ", this side as " + type.hash +
                 ": they do not hear each other",
             "build both sides with the same message definitions"});
  return false;
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
    if (!gone.is_participant()) continue;
    std::vector<dds::Gid> its;
    for (const auto& [gid, stand_in] : stand_ins) {
      if (gid.same_participant(gone)) its.push_back(gid);
    }
    for (const auto& gid : its) forget(gid);
  }
  gone_now.clear();
}

void DdsMirror::Impl::forget(const dds::Gid& gid) {
  if (stand_ins.erase(gid) != 0) stand_in_count = stand_ins.size();
  manual.erase(gid);
  std::erase_if(handles, [&](const auto& entry) { return entry.second == gid; });
  for (const auto& [id, reader] : readers) reader->sequences.erase(gid);
}

// A writer may show life without a message, of which DDS tells only when it stops and when it begins again. As long as
// it has not stopped, its stand-in shows it too.
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
