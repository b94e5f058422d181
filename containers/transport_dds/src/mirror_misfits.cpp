// SPDX-License-Identifier: Apache-2.0
// Reports about remote endpoints that are incompatible with some or all endpoints of this side.
#include <algorithm>

#include "mirror_impl.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/qos/compatibility.hpp"

namespace nacelle {
namespace {

// For announcements that follow an endpoint's: the name of its node (only ROS 2 nodes have one), and the node's other endpoints.
constexpr Duration kRestIsKnown = 1s;
// A bound, since a peer may announce any number.
constexpr std::size_t kMostNoted = 4096;

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

bool is_of_same_node(const dds::RemoteEndpoint& one, const dds::RemoteEndpoint& other) {
  return one.gid.same_participant(other.gid) && one.node_name == other.node_name &&
         one.node_namespace == other.node_namespace;
}

}  // namespace

bool DdsMirror::Impl::waits_for_name(const dds::RemoteEndpoint& end, const TopicUse& use,
                                     const msgs::MessageType& type) {
  const auto fitting = [&] {
    if (!is_same_definition(end, type)) return false;
    return end.is_writer ? would_match(use.readers, end, type) : would_match(use.writers, end, type);
  };
  // Once: an end of this side that is made later need not wait again.
  if (end.node_name == dds::kUnknownNodeName && !awaited.contains(end.gid) && !fitting()) {
    if (clock.now() - wait_in(nameless, end.gid) < kRestIsKnown) return true;
  }
  nameless.erase(end.gid);
  return false;
}

bool DdsMirror::Impl::fits(const dds::RemoteEndpoint& end, const msgs::MessageType& type) {
  if (is_same_definition(end, type)) return true;
  const std::string theirs = end.type + " as " + end.user_data.type_hash;
  tell_once(
      end.name + " " + end.user_data.type_hash,
      {end.name, node_name_of(end) + " has " + theirs + ", this side as " + type.hash + ": they do not hear each other",
       "build both sides with the same message definitions"});
  const TopicUse& use = topics.at(end.name);
  const auto note = [&](const EndpointInfo& ours) {
    if (ours.spec.type == &type) note_misfit(ours, end, theirs);
  };
  if (end.is_writer) {
    for (const LocalReader* reader : use.readers) note(reader->info);
  } else {
    for (const LocalWriter* writer : use.writers) note(writer->info);
  }
  return false;
}

void DdsMirror::Impl::note_misfit(const EndpointInfo& ours, const dds::RemoteEndpoint& end, const std::string& type) {
  if (misfits.size() < kMostNoted && misfits.emplace(end.gid, ours.id).second)
    graph.note_other_type(ours, node_name_of(end), type);
}

// --- other types -----------------------------------------------------------------------------------------------------

// For an endpoint without a stand-in: the graph reports the others itself. A node that reads both types misses nothing, such as a
// base that takes Twist and TwistStamped on one name.
std::vector<const EndpointInfo*> DdsMirror::Impl::those_with_other_types(const dds::RemoteEndpoint& end) const {
  std::vector<const EndpointInfo*> out;
  const auto use = topics.find(end.name);
  if (use == topics.end() || stand_ins.contains(end.gid)) return out;
  if (end.is_writer) {
    for (const LocalReader* reader : use->second.readers) out.push_back(&reader->info);
    return out;
  }
  for (const LocalWriter* writer : use->second.writers) out.push_back(&writer->info);
  if (out.empty()) return out;
  for (const auto& other : remote.lock()->ends_of_topic(end.name)) {
    if (other.is_writer || !is_of_same_node(other, end)) continue;
    std::erase_if(out, [&](const EndpointInfo* ours) { return ours->spec.type->name == other.type; });
  }
  return out;
}

void DdsMirror::Impl::tell_other_types(const dds::RemoteEndpoint& end) {
  const auto ours = those_with_other_types(end);
  if (ours.empty()) return;
  std::set<std::string> names;
  for (const EndpointInfo* one : ours) names.insert(one->spec.type->name);
  tell_once(end.name + " " + end.type + " " + end.gid.participant().text() + (end.is_writer ? " w" : " r"),
            {end.name,
             node_name_of(end) + (end.is_writer ? " publishes " : " reads ") + end.type + ", this side has " +
                 join({names.begin(), names.end()}) + ": they do not hear each other",
             "rename one of the topics with a remap, or make both sides use one type"});
  for (const EndpointInfo* one : ours) note_misfit(*one, end, end.type);
}

// --- readers elsewhere that ask for more ----------------------------------------------------------------------------

// A node that receives the writer by another subscription misses nothing.
std::vector<const EndpointInfo*> DdsMirror::Impl::those_that_do_not_serve(const dds::RemoteEndpoint& reader) const {
  std::vector<const EndpointInfo*> out;
  const auto use = topics.find(reader.name);
  if (reader.is_writer || use == topics.end()) return out;
  for (const LocalWriter* writer : use->second.writers) {
    const EndpointSpec& spec = writer->info.spec;
    if (spec.type->name == reader.type && !spec.node.empty() &&
        verdict_of(spec.qos.resolved(), reader.qos) == Verdict::Error)
      out.push_back(&writer->info);
  }
  if (out.empty()) return out;
  for (const auto& other : remote.lock()->ends_of_topic(reader.name)) {
    if (other.is_writer || other.type != reader.type || !is_of_same_node(other, reader)) continue;
    std::erase_if(out, [&](const EndpointInfo* ours) {
      return verdict_of(ours->spec.qos.resolved(), other.qos) != Verdict::Error;
    });
  }
  return out;
}

void DdsMirror::Impl::tell_unserved(const dds::RemoteEndpoint& reader) {
  for (const EndpointInfo* ours : those_that_do_not_serve(reader)) {
    const auto found = check(ours->spec.qos.resolved(), reader.qos);
    const auto worst = std::ranges::find(found.clashes, Verdict::Error, &Clash::severity);
    if (worst == found.clashes.end()) continue;
    tell_once(reader.name + " " + ours->spec.node + " " + reader.gid.text(),
              {reader.name, worst->between(ours->spec.node, node_name_of(reader)), worst->change});
  }
}

MonotonicTime DdsMirror::Impl::wait_in(std::map<dds::Gid, MonotonicTime>& those, const dds::Gid& gid) {
  const MonotonicTime since = those.try_emplace(gid, clock.now()).first->second;
  misfits_due = std::min(misfits_due, since + kRestIsKnown);
  return since;
}

MonotonicTime DdsMirror::Impl::look_at_misfits() {
  if (clock.now() < misfits_due) return misfits_due;
  MonotonicTime due = kNeverExpires;
  const auto is_due = [&](MonotonicTime since) {
    if (clock.now() - since >= kRestIsKnown) return true;
    due = std::min(due, since + kRestIsKnown);
    return false;
  };
  for (auto next = nameless.begin(); next != nameless.end();) {
    const auto [gid, since] = *next++;
    const auto end = remote.lock()->endpoint(gid);
    if (end && end->node_name == dds::kUnknownNodeName && !is_due(since)) continue;
    if (end) {
      awaited.insert(gid);
      consider(*end);
    }
    nameless.erase(gid);
  }
  const auto tell_of_due = [&](std::map<dds::Gid, MonotonicTime>& those, const auto& told_of) {
    for (auto next = those.begin(); next != those.end();) {
      const auto [gid, since] = *next++;
      const auto end = remote.lock()->endpoint(gid);
      if (end && !is_due(since)) continue;
      if (end) told_of(*end);
      those.erase(gid);
    }
  };
  tell_of_due(other_types, [this](const dds::RemoteEndpoint& end) { tell_other_types(end); });
  tell_of_due(unserved, [this](const dds::RemoteEndpoint& end) { tell_unserved(end); });
  return misfits_due = due;
}

}  // namespace nacelle
