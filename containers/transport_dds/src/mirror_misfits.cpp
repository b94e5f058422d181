// SPDX-License-Identifier: Apache-2.0
// Ends of other participants that this side does not hear, or not all of it: what is told of them, and when.
#include <algorithm>

#include "mirror_impl.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "nacelle/qos/compatibility.hpp"

namespace nacelle {
namespace {

// For what is announced behind an end: the name of its node (what is no node of ROS 2 has none), and the other ends of that.
constexpr Duration kRestIsKnown = 1s;

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
  if (end.node_name == dds::kUnknownNodeName && !fitting()) {
    const MonotonicTime since = nameless.try_emplace(end.gid, clock.now()).first->second;
    if (clock.now() - since < kRestIsKnown) return true;
  }
  nameless.erase(end.gid);
  return false;
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

// --- other types -----------------------------------------------------------------------------------------------------

// A node that reads both types misses nothing, as a base that takes Twist and TwistStamped on one name.
std::set<std::string> DdsMirror::Impl::other_types_than(const dds::RemoteEndpoint& end, const TopicUse& use) const {
  std::set<std::string> out;
  if (end.is_writer) {
    for (const LocalReader* reader : use.readers) {
      const bool reads_it = std::ranges::any_of(use.readers, [&](const LocalReader* other) {
        return other->info.spec.node == reader->info.spec.node && other->info.spec.type->name == end.type;
      });
      if (!reads_it) out.insert(reader->info.spec.type->name);
    }
    return out;
  }
  for (const LocalWriter* writer : use.writers) {
    if (writer->info.spec.type->name != end.type) out.insert(writer->info.spec.type->name);
  }
  if (out.empty()) return out;
  for (const auto& other : remote.lock()->ends_of_topic(end.name)) {
    if (!other.is_writer && is_of_same_node(other, end)) out.erase(other.type);
  }
  return out;
}

void DdsMirror::Impl::note_other_types(const dds::RemoteEndpoint& end, const TopicUse& use) {
  if (!other_types_than(end, use).empty()) other_types.try_emplace(end.gid, clock.now());
}

void DdsMirror::Impl::tell_other_types(const dds::RemoteEndpoint& end) {
  const auto use = topics.find(end.name);
  if (use == topics.end()) return;
  const auto ours = other_types_than(end, use->second);
  if (ours.empty()) return;
  tell_once(end.name + " " + end.type + " " + end.gid.participant().text() + (end.is_writer ? " w" : " r"),
            {end.name,
             node_name_of(end) + (end.is_writer ? " publishes " : " reads ") + end.type + ", this side has " +
                 join({ours.begin(), ours.end()}) + ": they do not hear each other",
             "rename one of the topics with a remap, or make both sides use one type"});
}

MonotonicTime DdsMirror::Impl::look_at_misfits() {
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
    if (end) consider(*end);
    nameless.erase(gid);
  }
  for (auto next = other_types.begin(); next != other_types.end();) {
    const auto [gid, since] = *next++;
    const auto end = remote.lock()->endpoint(gid);
    if (end && !is_due(since)) continue;
    if (end) tell_other_types(*end);
    other_types.erase(gid);
  }
  return due;
}

}  // namespace nacelle
