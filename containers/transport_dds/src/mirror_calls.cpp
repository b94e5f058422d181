// SPDX-License-Identifier: Apache-2.0
// Calls of this side to servers outside, and what these answer.
#include <algorithm>

#include "mirror_services.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

// After so many, others get their turn.
constexpr int kMostRepliesAtOnce = 256;
// The most unanswered calls of one client. Beyond it, the oldest calls get a notice that there will be no answer.
constexpr std::size_t kMostWaitingCalls = 1000;
// Both sides discover each other separately. A request that a client sends before the server's side has matched it is lost, and DDS
// does not report when it has. Therefore requests wait this long. kReplyPatience does the same for replies.
constexpr Duration kSettling = 100ms;

}  // namespace

void DdsMirror::Impl::Services::fail(const Asker& asker) {
  ++calls_failed;
  asker.answer(nullptr);
}

void DdsMirror::Impl::Services::send(Client& client, Call call) {
  // The server may have gone since the call was noted.
  if (!client.is_available) return fail(call.asker);
  const msgs::MessageType& type = *client.info.request;
  const dds::CallHeader header{client.writer->handle(), ++last_sequence};
  const std::size_t bytes = dds::call_size(type, call.request.get());
  auto payload = client.writer->borrow(bytes);
  if (!payload) {
    tell_once(client, "long",
              {"",
               "a request of " + std::to_string(bytes) +
                   " bytes did not go to the network: it is too long, or too many are on their way",
               ""});
    return fail(call.asker);
  }
  dds::write_call(header, type, call.request.get(), payload.bytes().data());
  if (client.writer->write(std::move(payload), mirror.clock.wall_now()) != dds::Writer::Sent::Yes)
    return fail(call.asker);
  ++calls;
  Client::Sent& sent = client.waiting[header.sequence];
  sent.asker = std::move(call.asker);
  for (const auto& [gid, server] : client.readers) {
    if (server.understands) sent.servers.insert(gid);
  }
  if (client.waiting.size() <= kMostWaitingCalls) return;
  fail(client.waiting.begin()->second.asker);
  client.waiting.erase(client.waiting.begin());
}

bool DdsMirror::Impl::Services::receive(Client& client) {
  for (int left = kMostRepliesAtOnce; left > 0; --left) {
    const auto sample = client.reader->take();
    if (!sample) return false;
    take_reply(client, *sample);
  }
  note_ready(client);
  return true;
}

void DdsMirror::Impl::Services::take_reply(Client& client, const dds::Sample& sample) {
  const auto server = client.writers.find(sample.writer);
  if (server != client.writers.end() && !server->second.understands) {
    ++mirror.stray;
    return;
  }
  const msgs::MessageType& type = *client.info.response;
  const auto call = dds::read_call(sample.payload.bytes(), scratch);
  const auto tell_broken = [&](msgs::DecodeFault fault) {
    ++mirror.broken;
    tell_once(client, "broken",
              {"",
               "what " + mirror.node_of(sample.writer) + " answered is no " + type.name + ": " + msgs::explain(fault) +
                   "; the next ones are only counted",
               ""});
  };
  if (!call) return tell_broken(call.error());
  // Every client of a service gets every reply.
  if (!dds::is_reply_to(call->header, client.writer->handle())) return;
  const auto sent = client.waiting.extract(call->header.sequence);
  if (sent.empty()) {
    ++late;
    return;
  }
  auto response = std::make_unique<msgs::AnyMessage>(type);
  if (const auto fine = type.decode(call->message, response->get()); !fine) {
    tell_broken(fine.error());
    return fail(sent.mapped().asker);
  }
  ++answers;
  sent.mapped().asker.answer(std::move(response));
}

void DdsMirror::Impl::Services::look_for_servers(Client& client) {
  const auto ids_of = [](const Peers& ends) {
    std::vector<std::string> ids;
    for (const auto& [gid, peer] : ends) {
      if (peer.understands) ids.push_back(peer.id);
    }
    return ids;
  };
  const bool has_met = dds::is_service_available(ids_of(client.readers), ids_of(client.writers));
  const MonotonicTime at = mirror.clock.now();
  if (!has_met) {
    client.settled = kNeverExpires;
    settling.erase(client.info.id);
  } else if (client.settled == kNeverExpires) {
    client.settled = at + kSettling;
    settling.insert(client.info.id);
  }
  const bool is_available = has_met && at >= client.settled;
  if (is_available) settling.erase(client.info.id);
  if (client.is_available != is_available) {
    client.is_available = is_available;
    graph.set_remote(client.info.id, is_available ? &client : nullptr);
  }
  // Each server that a request has reached answers it; if the last of them has ended, there will be no answer.
  for (auto call = client.waiting.begin(); call != client.waiting.end();) {
    Client::Sent& sent = call->second;
    std::erase_if(sent.servers, [&](const dds::Gid& server) { return !client.readers.contains(server); });
    if (sent.servers.empty()) fail(sent.asker);
    call = sent.servers.empty() ? client.waiting.erase(call) : std::next(call);
  }
}

void DdsMirror::Impl::Services::look_at_settling() {
  const MonotonicTime at = mirror.clock.now();
  // Those that have settled leave the set.
  for (const std::uint64_t id : std::set<std::uint64_t>(settling)) {
    Client& client = *clients.at(id);
    if (at >= client.settled) look_for_servers(client);
  }
}

}  // namespace nacelle
