// SPDX-License-Identifier: Apache-2.0
// The clocks of the machines that others run on.
#include <algorithm>

#include "mirror_impl.hpp"

namespace nacelle {
namespace {

constexpr std::size_t kMostSkewsTold = 256;  // a peer can make up as many hosts as it likes

}  // namespace

DdsMirror::Impl::Peer& DdsMirror::Impl::peer_of(const dds::RemoteEndpoint& writer) {
  const dds::Gid participant = writer.gid.participant();
  const auto [found, added] = peers.try_emplace(participant);
  Peer& peer = found->second;
  if (!added) return peer;
  const std::string host = remote.lock()->host_of(participant);
  // "host of participant 0110..., is 150 ms ahead"; as long as ClockSkew keeps it.
  const std::string prefix = participant.text().substr(0, 2 * dds::Gid::kPrefixBytes);
  peer.host = ClockSkew{host.empty() ? "of participant " + prefix : host, 1ns}.host();
  return peer;
}

// Of what was said before we listened the age says nothing; that it comes from the future says something all the same.
void DdsMirror::Impl::note_stamp(StandIn& from, WallTime source, WallTime received, MonotonicTime at) {
  const bool is_history = from.end.qos.durability() != Durability::Volatile && source <= received;
  if (from.peer == nullptr || is_history || !from.peer->clock.note(source, received, at)) return;
  publish_skews();
  tell_skew(from.peer->host);
}

// Programs of one host have one clock: where some show more than others, the most that is sure is told.
void DdsMirror::Impl::publish_skews() {
  std::map<std::string, Duration> hosts;
  for (const auto& [gid, peer] : peers) {
    Duration& ahead = hosts[peer.host];
    const Duration its = peer.clock.ahead();
    if (its > ahead || (ahead <= Duration::zero() && its < ahead)) ahead = its;
  }
  std::vector<ClockSkew> all;
  for (const auto& [host, ahead] : hosts) {
    if (ahead != Duration::zero()) all.emplace_back(host, ahead);
  }
  *host_skews.lock() = std::move(all);
  if (!options.clock_skews) return;
  ClockSkews::Table table;
  for (const auto& [gid, stand_in] : stand_ins) {
    if (stand_in.peer == nullptr || stand_in.peer->clock.ahead() == Duration::zero()) continue;
    table.emplace(stand_in.id, ClockSkew{stand_in.peer->host, stand_in.peer->clock.ahead()});
  }
  options.clock_skews->replace(std::move(table));
}

// Several programs of one host find out one after the other: it is told once.
void DdsMirror::Impl::tell_skew(const std::string& host) {
  const std::vector<ClockSkew> skews = *host_skews.lock();
  const auto now = std::ranges::find(skews, host, &ClockSkew::host);
  const auto told_before = told_skews.find(host);
  if (now == skews.end()) {
    if (told_before == told_skews.end()) return;
    told_skews.erase(told_before);
    return log.info("clock skew: the clock of host {} agrees with this machine's again", host);
  }
  const Duration ahead = now->ahead();
  if (told_before != told_skews.end()) {
    const Duration change = ahead - told_before->second, limit = dds::PeerClock::kLeastAhead;
    if (change < limit && change > -limit) return;
  } else if (told_skews.size() == kMostSkewsTold) {
    return;
  }
  told_skews[host] = ahead;
  log.warn(
      "clock skew: {}; its stamps do not fit those of this machine: synchronise both (chrony, or timedatectl set-ntp "
      "true)",
      now->text());
}

}  // namespace nacelle
