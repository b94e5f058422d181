// SPDX-License-Identifier: Apache-2.0
// The clocks of the machines that others run on.
#include <algorithm>

#include "mirror_clock_questions.hpp"
#include "mirror_impl.hpp"

namespace nacelle {
namespace {

constexpr std::size_t kMostSkewsTold = 256;  // a peer can make up as many hosts as it likes

ClockSkew skew_of(const std::string& host, const dds::PeerClock& clock) {
  return {host, clock.ahead(), clock.is_certain() ? ClockSkew::Sureness::Proven : ClockSkew::Sureness::Guessed};
}

bool says_more(const ClockSkew& one, const ClockSkew& other) {
  const bool is_ahead = one.ahead() > Duration::zero();
  if (is_ahead != (other.ahead() > Duration::zero())) return is_ahead;
  if (one.is_certain() != other.is_certain()) return one.is_certain();
  return is_ahead ? one.ahead() > other.ahead() : one.ahead() < other.ahead();
}

}  // namespace

DdsMirror::Impl::Peer& DdsMirror::Impl::peer_of(const dds::RemoteEndpoint& writer) {
  const dds::Gid owner = writer.gid.participant();
  const auto [found, added] = peers.try_emplace(owner);
  Peer& peer = found->second;
  if (!added) return peer;
  const std::string host = remote.lock()->host_of(owner);
  // "host of participant 0110..., is 150 ms ahead"; as long as ClockSkew keeps it.
  const std::string prefix = owner.text().substr(0, 2 * dds::Gid::kPrefixBytes);
  peer.host = ClockSkew{host.empty() ? "of participant " + prefix : host, 1ns}.host();
  return peer;
}

// The age of messages from before this reader existed is meaningless; a stamp from the future is not.
void DdsMirror::Impl::note_stamp(StandIn& from, WallTime source, WallTime came, MonotonicTime at) {
  const bool is_history = from.end.qos.durability() != Durability::Volatile && source <= came;
  if (from.peer == nullptr || is_history) return;
  if (from.peer->clock.note(source, came, at)) {
    publish_skews();
    tell_skew(from.peer->host);
  }
  if (from.peer->clock.is_worth_asking(at)) ask_for_time(from, at);
}

void DdsMirror::Impl::ask_for_time(StandIn& from, MonotonicTime at) {
  if (services && services->questions->add(from.end.gid.participant())) {
    from.peer->clock.begin_asking();
  } else {
    from.peer->clock.end_asking(at);
  }
}

// Programs of one host share one clock: if their estimates differ, the largest certain one is reported.
void DdsMirror::Impl::publish_skews() {
  std::map<std::string, ClockSkew> hosts;
  for (const auto& [gid, peer] : peers) {
    const ClockSkew its = skew_of(peer.host, peer.clock);
    if (!its) continue;
    ClockSkew& most = hosts[peer.host];
    if (!most || says_more(its, most)) most = its;
  }
  std::vector<ClockSkew> all;
  for (const auto& [host, skew] : hosts) all.push_back(skew);
  *host_skews.lock() = std::move(all);
  if (!options.clock_skews) return;
  ClockSkews::Table table;
  for (const auto& [gid, stand_in] : stand_ins) {
    if (stand_in.peer == nullptr || stand_in.peer->clock.ahead() == Duration::zero()) continue;
    table.emplace(stand_in.id, skew_of(stand_in.peer->host, stand_in.peer->clock));
  }
  options.clock_skews->replace(std::move(table));
}

// The estimates of several programs of one host arrive one after the other: the skew is reported once.
void DdsMirror::Impl::tell_skew(const std::string& host) {
  const std::vector<ClockSkew> skews = *host_skews.lock();
  const auto here = std::ranges::find(skews, host, &ClockSkew::host);
  const auto told_before = told_skews.find(host);
  if (here == skews.end()) {
    if (told_before == told_skews.end()) return;
    told_skews.erase(told_before);
    return log.info("clock skew: the clock of host {} agrees with this machine's again", host);
  }
  if (told_before != told_skews.end()) {
    const bool is_surer = here->is_certain() && !told_before->second.is_certain();
    const Duration change = here->ahead() - told_before->second.ahead(), limit = dds::PeerClock::kLeastAhead;
    if (!is_surer && change < limit && change > -limit) return;
  } else if (told_skews.size() == kMostSkewsTold) {
    return;
  }
  told_skews[host] = *here;
  log.warn(
      "clock skew: {}; its stamps do not fit those of this machine: synchronise both (chrony, or timedatectl set-ntp "
      "true)",
      here->text());
}

}  // namespace nacelle
