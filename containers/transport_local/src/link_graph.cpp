// SPDX-License-Identifier: Apache-2.0
// Who is there on both sides, and the stand-ins for the other side's.
#include <algorithm>
#include <cstring>

#include "link_services.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

// A robot's process has a few hundred.
constexpr std::size_t kMostEndpoints = wire::kMostReaders;
const std::atomic<bool> kClosed{false};

}  // namespace

// --- notifications of this side's graph ------------------------------------------------------------------------------

void Link::Impl::note(Event happened) noexcept {
  {
    const LockGuard lock(noting);
    events.push_back(std::move(happened));
  }
  wake();
}
void Link::Impl::on_made(const EndpointInfo& endpoint) noexcept {
  if (number == 0 || endpoint.spec.via != number) note({Event::Kind::Made, endpoint});
}
void Link::Impl::on_gone(std::uint64_t id) noexcept { note({Event::Kind::Gone, {.id = id}}); }
void Link::Impl::on_gate(std::uint64_t reader, bool open) noexcept {
  note({Event::Kind::Gate, {.id = reader, .open = open}});
}
void Link::Impl::on_life(std::uint64_t writer) noexcept {
  {
    const LockGuard lock(noting);
    // Several assertions in a row are merged into one.
    if (!events.empty() && events.back().kind == Event::Kind::Life && events.back().info.id == writer) return;
  }
  note({Event::Kind::Life, {.id = writer}});
}

bool Link::Impl::take_events() {
  {
    const LockGuard lock(noting);
    std::swap(events, events_now);
    std::swap(notes, notes_now);
  }
  bool did = !events_now.empty() || !notes_now.empty();
  for (const Event& happened : events_now) {
    const std::uint64_t id = happened.info.id;
    switch (happened.kind) {
      case Event::Kind::Made: take_made(happened.info); break;
      case Event::Kind::Gone: take_gone(id); break;
      case Event::Kind::Gate:
        if (local.contains(id))
          wire::append_id_and_byte(out, wire::LinkFrameKind::Gate, id, happened.info.open ? 1 : 0);
        break;
      case Event::Kind::Life:
        if (local.contains(id) && !is_full()) wire::append_id(out, wire::LinkFrameKind::Life, id);
        break;
    }
  }
  did |= services->take_events();
  for (const auto& note : notes_now) wire::append_note(out, as_bytes(note));
  events_now.clear();
  notes_now.clear();
  return did;
}

void Link::Impl::take_made(const EndpointInfo& endpoint) {
  if (!local.emplace(endpoint.id, endpoint).second) return;
  const EndpointSpec& spec = endpoint.spec;
  types[spec.type->name] = spec.type;
  wire::append_endpoint(out, {endpoint.id, endpoint.is_writer, endpoint.open, spec.qos, spec.topic, spec.type->name,
                              spec.type->hash, spec.node, spec.command_timeout.after, spec.command_timeout.parameter,
                              spec.announced, spec.unless_offered});
  TopicUse& use = topics[spec.topic];
  ++(endpoint.is_writer ? use.local_writers : use.local_readers);
  // One with a type that was unknown here may be wanted now.
  for (const auto id : use.remotes) remotes.at(id).refused = false;
  reconcile(spec.topic);
}

void Link::Impl::take_gone(std::uint64_t id) {
  const auto found = local.find(id);
  if (found == local.end()) return;
  const std::string topic = found->second.spec.topic;
  TopicUse& use = topics[topic];
  --(found->second.is_writer ? use.local_writers : use.local_readers);
  local.erase(found);
  lender->set(id, nullptr);
  departures.erase(id);
  {
    const LockGuard lock(noting);
    left.erase(id);
  }
  wire::append_id(out, wire::LinkFrameKind::Gone, id);
  reconcile(topic);
  forget_if_unused(topic);
}

// --- frames of the peer ----------------------------------------------------------------------------------------------

bool Link::Impl::handle_endpoint(const wire::LinkFrame& frame) {
  auto endpoint = wire::read_endpoint(frame);
  if (!endpoint || remotes.contains(endpoint->id) || local.contains(endpoint->id) || remotes.size() >= kMostEndpoints)
    return false;
  if (const auto fine = validate_full_topic_name(endpoint->topic); !fine) {
    log.error("a stream of {} is refused: {}", options.peer, fine.error().text());
    return true;  // messages for it have no reader
  }
  Remote& remote = remotes[endpoint->id];
  remote.info.id = endpoint->id;
  remote.info.is_writer = endpoint->is_writer;
  remote.info.open = endpoint->open;
  remote.info.spec.topic = endpoint->topic;
  remote.info.spec.qos = endpoint->qos;
  remote.info.spec.node = endpoint->node;
  remote.info.spec.via = number;
  remote.info.spec.command_timeout = {endpoint->command_timeout, endpoint->command_parameter};
  remote.info.spec.announced = endpoint->announced;
  remote.info.spec.unless_offered = endpoint->unless_offered;
  remote.type = endpoint->type;
  remote.hash = endpoint->hash;
  topics[endpoint->topic].remotes.push_back(endpoint->id);
  reconcile(endpoint->topic);
  return true;
}

void Link::Impl::handle_gone(std::uint64_t id) {
  const auto found = remotes.find(id);
  if (found == remotes.end()) return;
  const std::string topic = found->second.info.spec.topic;
  std::erase(topics.at(topic).remotes, id);
  if (found->second.arrival) found->second.arrival->reader->drain();  // messages sent before the end
  remotes.erase(found);
  forget_if_unused(topic);
}

void Link::Impl::forget_if_unused(const std::string& topic) {
  const TopicUse& use = topics.at(topic);
  if (use.remotes.empty() && use.local_writers + use.local_readers == 0) topics.erase(topic);
}

void Link::Impl::handle_gate(std::uint64_t id, bool open) {
  const auto found = remotes.find(id);
  if (found == remotes.end() || found->second.info.is_writer) return;
  found->second.info.open = open;
  if (Outbox* const outbox = found->second.outbox.get(); outbox != nullptr) {
    if (open) outbox->reader->forget_seen();
    outbox->reader->set_enabled(open);
    note_ready(*outbox);  // to report its losses
  }
}

// --- stand-ins ----------------------------------------------------------------------------------------------------------

void Link::Impl::reconcile(const std::string& topic) {
  const TopicUse& use = topics[topic];
  for (const auto id : use.remotes) {
    Remote& remote = remotes.at(id);
    const bool wanted = options.mirror_all || (remote.info.is_writer ? use.local_readers : use.local_writers) != 0;
    const bool there = remote.writer != nullptr || remote.outbox != nullptr;
    if (wanted && !there && !remote.refused) make_stand_in(remote);
    if (!wanted && there) drop_stand_in(remote);
  }
}

void Link::Impl::refuse(Remote& remote, const std::string& why, const std::string& way_out) {
  remote.refused = true;
  const EndpointSpec& spec = remote.info.spec;
  log.error("{}", Problem{spec.topic,
                          (spec.node.empty() ? options.peer : spec.node) +
                              (remote.info.is_writer ? " publishes " : " reads ") + remote.type + why,
                          way_out}
                      .text());
}

const msgs::MessageType* Link::Impl::find_type(const std::string& name) const {
  if (const auto known = types.find(name); known != types.end()) return known->second;
  return options.find_type ? options.find_type(name) : nullptr;
}

const msgs::MessageType* Link::Impl::type_for(Remote& remote) {
  const auto* type = find_type(remote.type);
  if (type == nullptr) {
    refuse(remote, ", which this process does not know: the stream is not linked",
           "install its message package here too");
  } else if (remote.hash != type->hash) {
    refuse(remote, " as " + remote.hash + ", this process has " + type->hash + ": the stream is not linked",
           "build both sides with the same message definitions");
    type = nullptr;
  }
  return type;
}

void Link::Impl::make_stand_in(Remote& remote) {
  const auto* const type = type_for(remote);
  if (type == nullptr) return;
  EndpointSpec& spec = remote.info.spec;
  spec.type = type;
  if (remote.info.is_writer) {
    remote.writer = graph.create_proxy_writer(spec, remote.info.id);
    return;
  }
  auto outbox = std::make_unique<Outbox>(*this, remote.info.id);
  EndpointSpec with = spec;
  with.gate = remote.info.open ? nullptr : &kClosed;
  with.status_listener = outbox.get();
  with.tells_lost = true;
  outbox->keeps_all = spec.qos.resolved().keeps_all();
  outbox->reader = graph.create_proxy_reader(with, outbox.get());
  if (carries && !outbox->keeps_all) outbox->reader->set_lender(lender);
  // What an earlier stand-in sent may still be acknowledged.
  remote.not_ours = remote.sent - remote.taken;
  remote.outbox = std::move(outbox);
}

void Link::Impl::drop_stand_in(Remote& remote) {
  if (remote.arrival) {
    // The next stand-in begins on the socket.
    remote.arrival.reset();
    wire::append_id_and_byte(out, wire::LinkFrameKind::Carry, remote.info.id,
                             static_cast<std::uint8_t>(wire::CarryStep::Close));
  }
  remote.writer.reset();
  remote.outbox.reset();
}

}  // namespace nacelle
