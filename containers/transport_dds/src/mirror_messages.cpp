// SPDX-License-Identifier: Apache-2.0
// Messages to and from the network.
#include <algorithm>

#include "mirror_impl.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

// After so many, others get their turn.
constexpr int kMostSentAtOnce = 16, kMostReceivedAtOnce = 256;
// More than one datagram: a slow network delays such a message, and all later ones on the same thread.
constexpr std::size_t kLarge = std::size_t{16} << 10U;
// For KEEP_ALL writers whose slowest reliable reader has not acknowledged enough.
constexpr Duration kRetryAfter = 5ms;

}  // namespace

// --- to the network --------------------------------------------------------------------------------------------------

bool DdsMirror::Impl::send(LocalWriter& end) {
  if (is_busy(end)) return false;
  int sent = 0;
  bool went = false;
  if (end.tap) {
    for (; sent < kMostSentAtOnce; ++sent) {
      if (end.unsent == nullptr) end.unsent = end.tap->take();
      if (end.unsent == nullptr) break;
      const std::size_t bytes = end.info.spec.type->encoded_size(end.unsent->message);
      const Passage passage = passage_of(end, bytes);
      if (passage == Passage::Waits) break;
      if (passage == Passage::Dropped) {
        end.drop_unsent();
        continue;
      }
      if (bytes >= kLarge) {
        write_at_lane(end, bytes);
        break;
      }
      if (!settle(end, write(end, *end.unsent, bytes))) break;
      went = true;
    }
    if (sent == kMostSentAtOnce) note_ready(end);
  }
  // A message shows it too.
  if (!end.at_lane && std::exchange(end.showed_life, false) && !went && end.writer) end.writer->assert_liveliness();
  return sent == kMostSentAtOnce;
}

void DdsMirror::Impl::count_overtaken(LocalWriter& end) {
  if (!end.tap) return;
  const std::uint64_t overwritten = end.tap->counters().overwritten;
  overtaken += overwritten - std::exchange(end.told_overwritten, overwritten);
}

// One of each writer at a time, so that they keep their order and large streams take turns.
void DdsMirror::Impl::write_at_lane(LocalWriter& end, std::size_t bytes) {
  end.at_lane = true;
  lane.add([this, &end, bytes] {
    end.by_lane = write(end, *end.unsent, bytes);
    end.lane_done = true;
    note_ready(end);
  });
}

bool DdsMirror::Impl::is_busy(LocalWriter& end) {
  if (!end.at_lane) return false;
  if (!end.lane_done.exchange(false)) return true;
  end.at_lane = false;
  return !settle(end, end.by_lane);
}

DdsMirror::Impl::Written DdsMirror::Impl::write(LocalWriter& end, const Block& block, std::size_t bytes) const {
  using enum Written::How;
  const bool keeps_all = end.info.spec.qos.resolved().keeps_all();
  auto payload = end.writer->borrow(bytes);
  if (!payload) {
    const bool later = keeps_all && bytes <= options.most_message_bytes && end.writer->out_count() != 0;
    return {later ? HeldUp : TooMuch, bytes};
  }
  end.info.spec.type->encode(block.message, payload.bytes().data());
  const WallTime source_time = clock.wall_now() - (clock.now() - block.info.source_time);
  const auto did = end.writer->write(std::move(payload), source_time);
  if (did == dds::Writer::Sent::Refused && keeps_all) return {HeldUp, bytes};
  return {did == dds::Writer::Sent::Yes ? Sent : Failed, bytes};
}

bool DdsMirror::Impl::settle(LocalWriter& end, const Written& did) {
  using enum Written::How;
  if (did.how == HeldUp) {
    hold_up(end, clock.now() + kRetryAfter);
    return false;
  }
  if (did.how != Sent) ++refused;
  if (did.how == TooMuch) {
    if (!std::exchange(end.told_refused, true))
      tell({end.info.spec.topic,
            "a message of " + std::to_string(did.bytes) +
                " bytes did not go to the network: it is too long, or too many are on their way; the others of this "
                "topic are only counted",
            ""});
  } else {
    ++encoded;
    bytes_encoded += did.bytes;
    end.tap->note_copied(did.bytes);
  }
  end.drop_unsent();
  return true;
}

// Of a writer with history the last word counts, however late: its messages wait for their turn. Of the others those
// that are too many are left out, by the times at which they were published.
DdsMirror::Impl::Passage DdsMirror::Impl::passage_of(LocalWriter& end, std::size_t bytes) {
  const auto topic = topics.find(end.info.spec.topic);  // none: of one that has ended, and was the last
  if (topic == topics.end() || !topic->second.gate || end.is_admitted) return Passage::Goes;
  dds::ExportGate& gate = *topic->second.gate;
  const bool waits = end.info.spec.qos.resolved().durability() == Durability::TransientLocal;
  const MonotonicTime at = waits ? clock.now() : end.unsent->info.source_time;
  end.is_admitted = gate.admits(at, bytes);
  if (end.is_admitted) return Passage::Goes;
  if (waits) {
    hold_up(end, gate.due(at, bytes));
    return Passage::Waits;
  }
  ++held_back;
  return Passage::Dropped;
}

void DdsMirror::Impl::hold_up(const LocalWriter& end, MonotonicTime until) {
  retry_at = held_up.empty() ? until : std::min(retry_at, until);
  held_up.insert(end.info.id);
}

// Returns when to look again.
MonotonicTime DdsMirror::Impl::send_held_up() {
  if (held_up.empty()) return kNeverExpires;
  if (clock.now() < retry_at) return retry_at;
  for (const auto id : std::exchange(held_up, {})) {
    if (const auto found = writers.find(id); found != writers.end()) send(*found->second);
  }
  return held_up.empty() ? kNeverExpires : retry_at;
}

void DdsMirror::Impl::send_snapshot() {
  const dds::Snapshot& message = own_nodes.message();
  const msgs::MessageType& type = dds::Snapshot::message_type();
  auto payload = snapshot_writer->borrow(type.encoded_size(&message));
  // Otherwise with the next turn.
  if (!payload) return;
  type.encode(&message, payload.bytes().data());
  if (snapshot_writer->write(std::move(payload), clock.wall_now()) != dds::Writer::Sent::Yes) return;
  is_snapshot_new = false;
  ++snapshots;
}

// --- from the network ------------------------------------------------------------------------------------------------

DdsMirror::Impl::StandIn* DdsMirror::Impl::stand_in_of(const dds::Sample& sample) {
  dds::Gid writer = sample.writer;
  if (writer == dds::Gid{}) {
    if (const auto known = handles.find(sample.writer_handle); known != handles.end()) writer = known->second;
  }
  auto found = stand_ins.find(writer);
  if (found == stand_ins.end()) {
    // Its message may arrive before the writer was looked up.
    take_discovery();
    found = stand_ins.find(writer);
  }
  return found == stand_ins.end() || !found->second.writer ? nullptr : &found->second;
}

// All readers of this process have the same bytes of a message in their queues. It is decoded once for all readers that have
// reached it.
bool DdsMirror::Impl::receive(TopicUse& use) {
  for (int left = kMostReceivedAtOnce;; --left) {
    LocalReader* first = nullptr;
    for (LocalReader* const end : use.readers) {
      if (!end->reader || !end->takes()) continue;
      if (!end->head) end->head = end->reader->take();
      if (end->head && first == nullptr) first = end;
    }
    if (first == nullptr) return false;
    if (left == 0) {
      note_ready(*first);
      return true;
    }
    ++received;
    StandIn* const from = stand_in_of(*first->head);
    if (from == nullptr) {
      ++stray;
      first->head.reset();
      continue;
    }
    const dds::Gid& writer = from->end.gid;
    const std::uint64_t sequence = first->sequences[writer] + 1;
    const std::uint8_t* const bytes = first->head->payload.bytes().data();
    same.clear();
    for (LocalReader* const end : use.readers) {
      if (end->head && end->takes() && end->head->payload.bytes().data() == bytes &&
          end->info.spec.type == from->type && end->sequences[writer] + 1 == sequence)
        same.push_back(end);
    }
    for (LocalReader* const end : same) end->sequences[writer] = sequence;
    if (same.empty()) ++stray;
    hand_on(same, *from, sequence);
    for (LocalReader* const end : same) end->head.reset();
    first->head.reset();
  }
}

void DdsMirror::Impl::hand_on(const std::vector<LocalReader*>& to, StandIn& from, std::uint64_t sequence) {
  if (to.empty()) return;
  const dds::Sample& sample = *to.front()->head;
  const ByteView bytes = sample.payload.bytes();
  Block* const block = from.writer->borrow();
  if (block == nullptr) return;
  if (const auto fine = from.type->decode(bytes, block->message); !fine) {
    drop_reference(*block);
    ++broken;
    if (!std::exchange(from.told_broken, true))
      tell({from.end.name,
            "what participant " + from.end.gid.participant().text() + " sent is no " + from.end.type + ": " +
                msgs::explain(fine.error()) + "; dropped and counted",
            ""});
    return;
  }
  ++decoded;
  targets.clear();
  for (const LocalReader* end : to) targets.push_back(end->info.id);
  // By the writer's clock; a clock that is ahead must not produce a stamp in the future.
  const WallTime came = clock.wall_now();
  const Duration age = std::max(came - sample.source_time, Duration::zero());
  const MonotonicTime at = clock.now();
  note_stamp(from, sample.source_time, came, at);
  const MonotonicTime source_time{std::max(at.since_origin - age, Duration::zero())};
  // As Cyclone has it: from when it came, so that clocks that differ let nothing expire.
  const Duration lifespan = from.end.qos.lifespan();
  const MonotonicTime expires = lifespan > Duration::zero() ? at + lifespan : kNeverExpires;
  from.writer->relay(*block, {from.id, sequence, source_time, {}}, expires, targets, bytes.size());
  if (manual.contains(from.end.gid)) {
    from.showed_life = at;
    from.writer->assert_liveliness();
  }
}

void DdsMirror::Impl::tell_losses(LocalReader& end) {
  if (!end.reader) return;
  const dds::ReaderCounters before = std::exchange(end.told, end.reader->counters());
  const std::uint64_t lost_before = std::exchange(end.told_lost, end.reader->status().lost);
  // What never came was overwritten at its writer, or on the way.
  const ReaderCounters losses{.overwritten = end.told.overwritten - before.overwritten + end.told_lost - lost_before,
                              .full = end.told.full - before.full};
  if (losses.overwritten + losses.full != 0) graph.note_lost(end.info, losses);
}

}  // namespace nacelle
