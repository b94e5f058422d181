// SPDX-License-Identifier: Apache-2.0
// How single streams change from the socket to a carrier and back (carrier.hpp).
//
// Order: a message of the socket and one of the carrier may overtake each other, so each change waits for the peer. To the
// carrier: Offer goes over the socket behind the last message, and nothing of the stream is sent until Accept comes. Back: the peer
// drains the carrier before it takes a message of the stream from the socket.
#include <fmt/format.h>

#include "link_impl.hpp"

namespace nacelle {

using wire::CarryStep;

namespace {

void append_step(Bytes& out, std::uint64_t writer, CarryStep step) {
  wire::append_id_and_byte(out, wire::LinkFrameKind::Carry, writer, static_cast<std::uint8_t>(step));
}

}  // namespace

CarriedStream Link::Impl::carried_stream(std::uint64_t writer, const EndpointSpec& spec, std::uint64_t sender) {
  return {fmt::format("{:x}.{:x}{}", sender, writer, spec.topic), spec.type, spec.qos.resolved().queue_capacity()};
}

// --- the writer's side --------------------------------------------------------------------------------------------------

bool Link::Impl::may_send(const Block& block, const TopicUse& topic) {
  const std::uint64_t writer = block.info.writer_id;
  if (!carries) return true;
  const auto known = local.find(writer);
  if (known == local.end()) return true;
  const auto [found, is_new] = departures.try_emplace(writer);
  Departure& departure = found->second;
  if (is_new) {
    // The stand-in for the writer is there first: it was announced before this.
    append_step(out, writer, CarryStep::Open);
    departure.writer = options.carrier->create_writer(carried_stream(writer, known->second.spec, token));
    if (!departure.writer) close_departure(writer, "the carrier cannot take it");
  }
  if (departure.step == Departure::Step::Carried || departure.step == Departure::Step::Closed) return true;
  for (const auto id : topic.remotes) {
    const auto& remote = remotes.at(id);
    if (remote.outbox && remote.outbox->keeps_all) return true;  // acknowledged one by one, on the socket
  }
  if (departure.step == Departure::Step::Opening && departure.writer->is_connected()) {
    append_step(out, writer, CarryStep::Offer);
    departure.step = Departure::Step::Offered;
  }
  return departure.step != Departure::Step::Offered;
}

bool Link::Impl::send_by_carrier(Block& block, const Outbox& outbox) {
  const auto found = departures.find(block.info.writer_id);
  if (found == departures.end() || found->second.step != Departure::Step::Carried) return false;
  switch (found->second.writer->send(block)) {
    case CarrierWriter::Sent::Yes: {
      ++carried;
      const std::uint64_t copied = found->second.writer->bytes_copied();
      if (const auto bytes = copied - std::exchange(found->second.told_copied, copied); bytes != 0)
        outbox.reader->note_copied(bytes);
      return true;
    }
    case CarrierWriter::Sent::Refused:
      close_departure(found->first, "the carrier refused a message of it");
      return false;
    case CarrierWriter::Sent::Dead: break;
  }
  carries = false;
  for (auto& [writer, departure] : departures) close_departure(writer, "the carrier is gone");
  return false;
}

// What follows on the carrier must not overtake it.
void Link::Impl::socket_used(std::uint64_t writer) {
  const auto found = departures.find(writer);
  if (found != departures.end() && found->second.step == Departure::Step::Carried)
    found->second.step = Departure::Step::Opening;
}

void Link::Impl::close_departure(std::uint64_t writer, const std::string& why) {
  Departure& departure = departures.at(writer);
  if (departure.step == Departure::Step::Closed) return;
  departure.step = Departure::Step::Closed;
  lender->set(writer, nullptr);
  append_step(out, writer, CarryStep::Close);
  const auto known = local.find(writer);
  log.warn("{} to {} goes over the socket from now on: {}",
           known == local.end() ? "a stream" : known->second.spec.topic, options.peer, why);
}

bool Link::Impl::handle_carry(ByteView payload) {
  const auto word = wire::read_id_and_byte(payload);
  if (!word || word->second > static_cast<std::uint8_t>(CarryStep::Close)) return false;
  const auto step = static_cast<CarryStep>(word->second);
  const std::uint64_t writer = word->first;
  if (const auto mine = departures.find(writer); mine != departures.end()) {
    Departure& departure = mine->second;
    if (step == CarryStep::Close) close_departure(writer, "the other side cannot take it by the carrier");
    if (step == CarryStep::Accept && departure.step == Departure::Step::Offered)
      departure.step = Departure::Step::Carried;
    if (departure.step == Departure::Step::Carried) lender->set(writer, departure.writer.get());
    // Those that waited for this.
    for (const auto id : topics[local.at(writer).spec.topic].remotes) {
      if (const auto& outbox = remotes.at(id).outbox) note_ready(*outbox);
    }
    return true;
  }
  const auto found = remotes.find(writer);
  if (found == remotes.end() || !found->second.info.is_writer) {
    // Unknown, or refused by name: a writer that waits for an answer gets one.
    if (step == CarryStep::Open || step == CarryStep::Offer) append_step(out, writer, CarryStep::Close);
    return true;
  }
  Remote& remote = found->second;
  if (step == CarryStep::Open) open_arrival(remote);
  if (step == CarryStep::Offer) append_step(out, writer, remote.arrival ? CarryStep::Accept : CarryStep::Close);
  if (step == CarryStep::Close && remote.arrival) {
    remote.arrival->reader->drain();
    remote.arrival.reset();
  }
  return true;
}

// --- the reader's side --------------------------------------------------------------------------------------------------

// For callers that pump: delivers now what the carrier's thread would deliver later.
bool Link::Impl::drain_carrier() {
  const LockGuard lock(pumping);
  const std::uint64_t before = arrived;
  for (const auto& [id, remote] : remotes) {
    if (remote.arrival) remote.arrival->reader->drain();
  }
  return arrived != before;
}

void Link::Impl::open_arrival(Remote& remote) {
  if (remote.arrival) return;
  if (carries && remote.writer) {
    auto arrival = std::make_unique<Arrival>(*this, *remote.writer, remote.info.spec);
    arrival->reader =
        options.carrier->create_reader(carried_stream(remote.info.id, remote.info.spec, peer_token), *arrival);
    if (arrival->reader) remote.arrival = std::move(arrival);
  }
  if (!remote.arrival) append_step(out, remote.info.id, CarryStep::Close);
}

Block* Link::Impl::Arrival::borrow() noexcept {
  const LockGuard lock(relaying);
  Block* const block = writer.borrow();
  if (block == nullptr) ++link.dropped;
  return block;
}

void Link::Impl::Arrival::deliver(Block& block, const MessageInfo& info) noexcept {
  const Duration lifespan = spec.qos.resolved().lifespan();
  const MonotonicTime expires = lifespan == Duration::zero() ? kNeverExpires : info.source_time + lifespan;
  const LockGuard lock(relaying);
  writer.relay(block, info, expires, {}, 0);
  ++link.arrived;
}

void Link::Impl::Arrival::note_broken(const char* why) noexcept {
  ++link.broken;
  if (std::exchange(told_broken, true)) return;
  link.log.error("{}: the carrier brought no message of its type from {}: {}; dropped and counted", spec.topic,
                 link.options.peer, why);
}

}  // namespace nacelle
