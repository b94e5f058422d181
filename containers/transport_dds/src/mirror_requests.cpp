// SPDX-License-Identifier: Apache-2.0
// Requests from outside to servers of this side, and what these answer.
#include <algorithm>

#include "mirror_services.hpp"
#include "nacelle/msgs/message_type.hpp"

namespace nacelle {
namespace {

// After so many, others get their turn.
constexpr int kMostRequestsAtOnce = 64;
// Requests from outside to one server that it has not answered. An action's results are such answers, as long as its
// goals take.
constexpr std::size_t kMostWaitingRequests = 256;

}  // namespace

bool DdsMirror::Impl::Services::receive(Server& server) {
  for (int left = kMostRequestsAtOnce; left > 0; --left) {
    const auto sample = server.reader->take();
    if (!sample) return false;
    take_request(server, *sample);
  }
  note_ready(server);
  return true;
}

void DdsMirror::Impl::Services::take_request(Server& server, const dds::Sample& sample) {
  auto client = server.writers.find(sample.writer);
  if (client == server.writers.end()) {
    // Its request may arrive before the client was looked up.
    server.writers = peers_of(server, true);
    client = server.writers.find(sample.writer);
  }
  if (client == server.writers.end() || !client->second.understands) {
    ++mirror.stray;
    return;
  }
  const msgs::MessageType& type = *server.info.request;
  const auto call = dds::read_call(sample.payload.bytes(), scratch);
  msgs::AnyMessage request{type};
  const auto fine =
      call ? type.decode(call->message, request.get()) : Result<void, msgs::DecodeFault>{err(call.error())};
  if (!fine) {
    ++mirror.broken;
    return tell_once(server, "broken",
                     {"",
                      "what " + mirror.node_of(sample.writer) + " sent is no " + type.name + ": " +
                          msgs::explain(fine.error()) + "; it is not answered, and the next ones are only counted",
                      ""});
  }
  const Server::Asked asked{call->header, sample.writer};
  // Another server of that name and another type is not the one that is refused.
  const auto refusal = mirror.options.refused.find(server.info.name);
  if (refusal != mirror.options.refused.end() && &refusal->second->type() == server.info.response)
    return refuse(server, asked, *refusal->second);
  if (server.waiting.size() >= kMostWaitingRequests) {
    ++requests_refused;
    return tell_once(server, "full",
                     {"",
                      std::to_string(kMostWaitingRequests) +
                          " requests from the network wait for an answer: more are not taken, only counted",
                      "see `nacelle top` for what its node is busy with"});
  }
  server.waiting.emplace(++server.last, asked);
  const auto did = graph.send(server.info.id, {{server.self, server.last}, std::move(request)});
  if (did == ServiceGraph::Sent::Yes) {
    ++requests;
    return;
  }
  // As with a server that has ended: DDS cannot express "not now".
  server.waiting.erase(server.last);
  ++requests_refused;
  if (did == ServiceGraph::Sent::Closed)
    tell_once(server, "closed",
              {"",
               mirror.node_of(sample.writer) + " has called it while " + server.info.node +
                   " is not active: such requests are not answered, only counted",
               "activate the node, or let the caller wait for it"});
}

void DdsMirror::Impl::Services::refuse(Server& server, const Server::Asked& asked, const msgs::AnyMessage& response) {
  ++requests_refused;
  auto held = std::make_unique<msgs::AnyMessage>(response.type());
  response.type().copy_assign(held->get(), response.get());
  Server::Held answer{asked, std::move(held), mirror.clock.now()};
  if (!reply(server, answer)) hold(server, std::move(answer));
}

// --- replies ---------------------------------------------------------------------------------------------------------

void DdsMirror::Impl::Services::take_answer(Server& server, std::int64_t sequence,
                                            std::unique_ptr<msgs::AnyMessage> response) {
  const auto asked = server.waiting.extract(sequence);
  if (asked.empty()) return;
  if (!response) {
    // Its node went, or was deactivated before it could answer: a caller outside can only be left waiting.
    ++requests_refused;
    return;
  }
  Server::Held answer{asked.mapped(), std::move(response), mirror.clock.now()};
  if (!reply(server, answer)) hold(server, std::move(answer));
}

void DdsMirror::Impl::Services::hold(Server& server, Server::Held answer) {
  if (server.held.size() >= kMostWaitingRequests) {
    server.held.pop_front();
    ++replies_dropped;
  }
  server.held.push_back(std::move(answer));
  holding.insert(server.info.id);
}

bool DdsMirror::Impl::Services::reply(Server& server, const Server::Held& answer) {
  // A reader that is matched and not among these yet comes with a status, after which we are here again.
  const auto client = server.writers.find(answer.asked.client);
  const std::string* const client_id = client == server.writers.end() ? nullptr : &client->second.id;
  std::vector<std::string> reader_ids;
  reader_ids.reserve(server.readers.size());
  for (const auto& [gid, reader] : server.readers) {
    if (reader.understands) reader_ids.push_back(reader.id);
  }
  switch (dds::reply_step(client_id, reader_ids, mirror.clock.now() - answer.since)) {
    case dds::ReplyStep::Send:
      send(server, answer.asked.header, *server.info.response, answer.response->get());
      return true;
    case dds::ReplyStep::Wait: return false;
    case dds::ReplyStep::Drop:
    case dds::ReplyStep::GiveUp: ++replies_dropped; return true;
  }
  return true;
}

void DdsMirror::Impl::Services::send(Server& server, const dds::CallHeader& header, const msgs::MessageType& type,
                                     const void* response) {
  const std::size_t bytes = dds::call_size(type, response);
  auto payload = server.writer->borrow(bytes);
  if (payload) {
    dds::write_call(header, type, response, payload.bytes().data());
    if (server.writer->write(std::move(payload), mirror.clock.wall_now()) == dds::Writer::Sent::Yes) {
      ++replies;
      return;
    }
  }
  ++replies_dropped;
  tell_once(server, "long",
            {"",
             "a response of " + std::to_string(bytes) +
                 " bytes did not go to the network: it is too long, or too many are on their way",
             ""});
}

void DdsMirror::Impl::Services::reply_to_held() {
  for (auto id = holding.begin(); id != holding.end();) {
    Server& server = *servers.at(*id);
    std::erase_if(server.held, [&](const Server::Held& answer) { return reply(server, answer); });
    id = server.held.empty() ? holding.erase(id) : std::next(id);
  }
}

}  // namespace nacelle
