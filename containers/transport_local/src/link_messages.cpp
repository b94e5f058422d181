// SPDX-License-Identifier: Apache-2.0
// Messages over the socket, their acknowledgements, and losses.
#include <algorithm>

#include "link_impl.hpp"
#include "nacelle/base/mutex.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

// One message may wait for several readers: the oldest is sent first, so that each reader gets its messages in order.
bool is_older(const Block& a, const Block& b) {
  if (a.info.source_time != b.info.source_time) return a.info.source_time < b.info.source_time;
  if (a.info.writer_id != b.info.writer_id) return a.info.writer_id < b.info.writer_id;
  return a.info.sequence < b.info.sequence;
}

}  // namespace

void Link::Impl::note_ready(Outbox& outbox) noexcept {
  if (outbox.queued.exchange(true)) return;
  {
    const LockGuard lock(noting);
    ready.push_back(outbox.id);
  }
  wake();
}

void Link::Impl::on_left(std::uint64_t reader) noexcept {
  {
    const LockGuard lock(noting);
    Left& gone = left[reader];
    ++gone.count;
    gone.dirty = true;
  }
  wake();
}

bool Link::Impl::send_ready() {
  // While the peer does not read, ready messages stay ready. Nothing wakes this thread for them again but room in the socket.
  held_back = is_full();
  if (held_back) return false;
  {
    const LockGuard lock(noting);
    std::swap(ready, ready_now);
  }
  const bool did = !ready_now.empty();
  again.clear();
  for (const auto id : ready_now) {
    const auto found = remotes.find(id);
    if (found == remotes.end() || !found->second.outbox) continue;
    Outbox& outbox = *found->second.outbox;
    // Before the queue is read: a message that comes meanwhile is announced again.
    outbox.queued = false;
    send_topic(topics.at(found->second.info.spec.topic));
    // Also one with an empty queue: its losses may not have been reported.
    if (is_full() && !outbox.queued.exchange(true)) again.push_back(id);
  }
  ready_now.clear();
  held_back = !again.empty();
  if (held_back) {
    const LockGuard lock(noting);
    ready.insert(ready.end(), again.begin(), again.end());
  }
  for (auto& [id, remote] : remotes) {
    // A closed gate drops without a word.
    if (remote.outbox && !remote.info.open) tell_losses(*remote.outbox);
  }
  return did;
}

void Link::Impl::send_topic(const TopicUse& topic) {
  outboxes.clear();
  for (const auto id : topic.remotes) {
    const auto& remote = remotes.at(id);
    if (remote.outbox) outboxes.push_back(remote.outbox.get());
  }
  while (!is_full()) {
    const Outbox* first = nullptr;
    for (Outbox* const outbox : outboxes) {
      fetch_head(*outbox);
      if (outbox->head != nullptr && (first == nullptr || is_older(*outbox->head, *first->head))) first = outbox;
    }
    if (first == nullptr) break;
    Block& block = *first->head;
    if (!may_send(block, topic)) break;
    same.clear();
    for (Outbox* const outbox : outboxes) {
      if (outbox->head == &block) same.push_back(outbox);
    }
    // The carrier's message is for all; one that is for some only goes over the socket.
    const bool for_all = same.size() == outboxes.size() && std::ranges::none_of(same, &Outbox::keeps_all);
    if (!for_all || !send_by_carrier(block, *first)) {
      send_message(block, *remotes.at(first->id).info.spec.type, same);
      socket_used(block.info.writer_id);
    }
    for (Outbox* const outbox : same) {
      outbox->head = nullptr;
      drop_reference(block);
    }
  }
  for (Outbox* const outbox : outboxes) tell_losses(*outbox);
}

void Link::Impl::fetch_head(Outbox& outbox) {
  if (outbox.head == nullptr) outbox.head = outbox.keeps_all ? outbox.reader->look() : outbox.reader->take();
}

void Link::Impl::send_message(Block& block, const msgs::MessageType& type, const std::vector<Outbox*>& to) {
  targets.clear();
  const std::size_t bytes = type.encoded_size(block.message);
  for (Outbox* const outbox : to) {
    targets.push_back(outbox->id);
    ++remotes.at(outbox->id).sent;
  }
  if (bytes > wire::kLongestLinkPayload / 2) {
    log.error("a message of {} bytes from writer {:x} is longer than a link carries: dropped", bytes,
              block.info.writer_id);
    for (Outbox* const outbox : to) {
      wire::append_lost(out, {outbox->id, 0, 1, 0, 0});
      if (outbox->keeps_all) {
        --remotes.at(outbox->id).sent;
        outbox->reader->release(1);
      }
    }
    return;
  }
  std::uint8_t* const cdr = wire::append_data(out,
                                              {block.info.writer_id,
                                               block.info.sequence,
                                               block.info.source_time.nanoseconds(),
                                               block.expires.nanoseconds(),
                                               {}},
                                              targets, bytes);
  type.encode(block.message, cdr);
  to.front()->reader->note_copied(bytes);
  ++sent;
}

bool Link::Impl::tell_losses(Outbox& outbox) {
  if (is_full()) return false;  // later, all in one
  const ReaderCounters now = outbox.reader->counters();
  wire::LostFrame lost{outbox.id, now.overwritten - outbox.told.overwritten, now.full - outbox.told.full,
                       now.expired - outbox.told.expired, now.inactive - outbox.told.inactive};
  // A KEEP_ALL one's have been sent; the reader drops and counts them itself.
  if (outbox.keeps_all) lost.expired = 0;
  outbox.told = now;
  if (lost.overwritten + lost.full + lost.expired + lost.inactive == 0) return false;
  wire::append_lost(out, lost);
  return true;
}

bool Link::Impl::tell_taken() {
  taken_now.clear();
  {
    const LockGuard lock(noting);
    for (auto& [id, gone] : left) {
      if (std::exchange(gone.dirty, false)) taken_now.emplace_back(id, gone.count);
    }
  }
  for (const auto& [id, count] : taken_now) {
    if (local.contains(id)) wire::append_id_and_count(out, wire::LinkFrameKind::Taken, id, count);
  }
  return !taken_now.empty();
}

// --- receiving -------------------------------------------------------------------------------------------------------

bool Link::Impl::handle_data(ByteView payload) {
  const auto data = wire::read_data(payload, targets);
  if (!data) return false;
  ++received;
  const auto found = remotes.find(data->writer);
  Block* block = nullptr;
  if (found == remotes.end() || !found->second.writer) {
    ++dropped;
  } else if (Remote& remote = found->second; remote.arrival) {
    // First the earlier messages, which the carrier brought.
    remote.arrival->reader->drain();
    block = remote.arrival->borrow();
  } else {
    block = remote.writer->borrow();
    if (block == nullptr) ++dropped;
  }
  if (block != nullptr) {
    if (const auto decoded = found->second.info.spec.type->decode(data->cdr, block->message); !decoded) {
      ++broken;
      if (!std::exchange(found->second.told_broken, true)) {
        log.error("{}: what {} sent is no {}: {}; dropped and counted", found->second.info.spec.topic, options.peer,
                  found->second.type, msgs::explain(decoded.error()));
      }
      drop_reference(*std::exchange(block, nullptr));
    }
  }
  if (block == nullptr) {
    // The writer's side waits for word of each message that a KEEP_ALL reader should have got.
    for (const auto id : targets) {
      const auto reader = local.find(id);
      if (reader != local.end() && reader->second.spec.qos.resolved().keeps_all()) on_left(id);
    }
    return true;
  }
  const MessageInfo info{data->writer, data->sequence, {Duration{data->source_ns}}, {}};
  const auto hand_on = [&]() NACELLE_REQUIRES(pumping) {
    found->second.writer->relay(*block, info, {Duration{data->expires_ns}}, targets, data->cdr.size());
  };
  if (found->second.arrival) {
    const LockGuard alone(found->second.arrival->relaying);
    hand_on();
  } else {
    hand_on();
  }
  return true;
}

bool Link::Impl::handle_taken(ByteView payload) {
  const auto word = wire::read_id_and_count(payload);
  if (!word) return false;
  const auto found = remotes.find(word->first);
  if (found == remotes.end()) return true;
  Remote& remote = found->second;
  // More than was sent is a lie, less than before an old word.
  const std::uint64_t now = std::min(word->second, remote.sent);
  if (now <= remote.taken) return true;
  std::uint64_t newly = now - std::exchange(remote.taken, now);
  const std::uint64_t others = std::min(newly, remote.not_ours);
  remote.not_ours -= others;
  newly -= others;
  if (newly != 0 && remote.outbox && remote.outbox->keeps_all) remote.outbox->reader->release(newly);
  return true;
}

void Link::Impl::handle_lost(const wire::LostFrame& lost) {
  const auto found = local.find(lost.reader);
  if (found == local.end() || found->second.is_writer) return;
  graph.note_lost(
      found->second,
      {.overwritten = lost.overwritten, .full = lost.full, .inactive = lost.inactive, .expired = lost.expired});
}

}  // namespace nacelle
