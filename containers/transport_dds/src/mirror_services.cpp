// SPDX-License-Identifier: Apache-2.0
// Servers and clients of this side, their endpoints, and the matched remote endpoints.
#include "mirror_services.hpp"

#include <algorithm>

#include "mirror_clock_questions.hpp"
#include "nacelle/msgs/message_type.hpp"
#include "transport_dds/wire/names.hpp"
#include "transport_dds/wire/user_data.hpp"

namespace nacelle {
namespace {

// Of each end, until the network's thread takes them: more than any history announces, so that a busy moment of that
// thread costs no request.
constexpr std::size_t kQueueOfService = 1000;
constexpr std::size_t kMostScratch = std::size_t{1} << 20U;  // one long request is no reason to keep its memory
// Calls of one client that wait to be sent.
constexpr std::size_t kMostNotedCalls = 256;

std::string service_type_of(const ServiceEndInfo& info) {
  return dds::service_of_half(info.request->name).value_or(info.request->name);
}

}  // namespace

// --- notifications ---------------------------------------------------------------------------------------------------

DdsMirror::Impl::Services::Services(DdsMirror::Impl& owner, ServiceGraph& of)
    : mirror(owner), graph(of), questions(std::make_unique<Questions>(*this)) {
  graph.join(*this);
}

DdsMirror::Impl::Services::~Services() {
  graph.leave(*this);
  for (const auto& [id, client] : clients) graph.set_remote(id, nullptr);
  for (const NotedCall& call : noted.calls) fail(call.call.asker);
  for (const auto& [id, client] : clients) {
    for (const auto& [sequence, sent] : client->waiting) fail(sent.asker);
  }
  servers.clear();
  clients.clear();
}

template <typename F>
void DdsMirror::Impl::Services::note(F change) noexcept {
  {
    const LockGuard lock(noting);
    change(noted);
  }
  mirror.note_services();
}

void DdsMirror::Impl::Services::on_made(const ServiceEndInfo& end) noexcept {
  note([&](Noted& to) { to.events.push_back({true, end}); });
}

void DdsMirror::Impl::Services::on_gone(std::uint64_t id) noexcept {
  note([&](Noted& to) {
    to.events.push_back({false, {}});
    to.events.back().info.id = id;
  });
}

void DdsMirror::Impl::Services::note_ready(End& end) noexcept {
  if (end.queued.exchange(true)) return;
  note([&](Noted& to) { to.ready.push_back(end.info.id); });
}

DdsMirror::Impl::Services::Server::Server(Services& owner, ServiceEndInfo of)
    : End(owner, std::move(of)),
      self(std::make_shared<Guarded<AnswerTaker*>>(std::in_place, static_cast<AnswerTaker*>(this))) {}

DdsMirror::Impl::Services::Server::~Server() {
  *self->lock() = nullptr;  // after this no server reaches it any more
  close();
}

void DdsMirror::Impl::Services::Server::push(std::int64_t sequence, std::unique_ptr<msgs::AnyMessage> response) {
  services.note([&](Noted& to) { to.answers.push_back({info.id, sequence, std::move(response)}); });
}

bool DdsMirror::Impl::Services::Client::take(Call call) noexcept {
  bool has_room = false;
  services.note([&](Noted& to) {
    has_room = noted < kMostNotedCalls;
    if (!has_room) return;
    ++noted;
    to.calls.push_back({info.id, std::move(call)});
  });
  return has_room;
}

// --- the network's thread --------------------------------------------------------------------------------------------

void DdsMirror::Impl::Services::turn() {
  {
    const LockGuard lock(noting);
    std::swap(noted, now);
    for (const NotedCall& call : now.calls) {
      if (const auto client = clients.find(call.client); client != clients.end()) client->second->noted = 0;
    }
  }
  // Whose end is among the events has answered and called before it.
  for (Answer& answer : now.answers) {
    const auto server = servers.find(answer.server);
    if (server != servers.end()) take_answer(*server->second, answer.sequence, std::move(answer.response));
  }
  for (NotedCall& call : now.calls) {
    const auto client = clients.find(call.client);
    if (client != clients.end()) send(*client->second, std::move(call.call));
  }
  for (const Event& event : now.events) {
    if (event.made) {
      take_made(event.info);
    } else {
      take_gone(event.info.id);
    }
  }
  for (const std::uint64_t id : now.ready) look_at(id);
  reply_to_held();
  look_at_settling();
  questions->turn();
  now.events.clear();
  now.answers.clear();
  now.calls.clear();
  now.ready.clear();
  if (scratch.capacity() > kMostScratch) scratch = {};
}

MonotonicTime DdsMirror::Impl::Services::due() const {
  MonotonicTime first = questions->due();
  for (const std::uint64_t id : holding) {
    const auto server = servers.find(id);
    if (server != servers.end()) first = std::min(first, server->second->held.front().since + dds::kReplyPatience);
  }
  for (const std::uint64_t id : settling) {
    if (const auto client = clients.find(id); client != clients.end()) first = std::min(first, client->second->settled);
  }
  return first;
}

void DdsMirror::Impl::Services::look_at(std::uint64_t id) {
  if (const auto found = servers.find(id); found != servers.end()) {
    Server& server = *found->second;
    // Reset before reading: events that arrive meanwhile signal again.
    server.queued = false;
    if (server.is_status_new.exchange(false)) {
      server.writers = peers_of(server, true);
      server.readers = peers_of(server, false);
    }
    receive(server);
  } else if (const auto asks = clients.find(id); asks != clients.end()) {
    Client& client = *asks->second;
    client.queued = false;
    const bool is_status_new = client.is_status_new.exchange(false);
    // Before ends are processed: the last messages of endpoints that have ended.
    const bool is_more_there = receive(client);
    if (!is_status_new) return;
    if (is_more_there) {
      client.is_status_new = true;
      return;
    }
    client.writers = peers_of(client, true);
    client.readers = peers_of(client, false);
    look_for_servers(client);
  } else {
    questions->look_at(id);
  }
}

void DdsMirror::Impl::Services::take_made(const ServiceEndInfo& info) {
  // A list of what others may see names services as it names topics.
  const auto& exports = mirror.options.exports;
  if (!exports.empty() && dds::rule_of(exports, info.name, service_type_of(info)) == nullptr) return;
  std::unique_ptr<Server> server;
  std::unique_ptr<Client> client;
  End* end = nullptr;
  if (info.is_server) {
    server = std::make_unique<Server>(*this, info);
    end = server.get();
  } else {
    client = std::make_unique<Client>(*this, info);
    end = client.get();
  }
  if (const auto opened = open(*end); !opened)
    return mirror.tell(end_not_shown("service " + info.name, info.name, opened.error()));
  mirror.show(info.node, end->reader->gid(), false);
  mirror.show(info.node, end->writer->gid(), true);
  if (server) servers.emplace(info.id, std::move(server));
  if (client) clients.emplace(info.id, std::move(client));
  server_count = servers.size();
  client_count = clients.size();
  // What came before the end was to be found.
  end->queued = false;
  end->is_status_new = true;
  note_ready(*end);
}

// The reader of a server takes requests, its writer gives replies; a client's the other way round.
Result<void, Problem> DdsMirror::Impl::Services::open(End& end) {
  const ServiceEndInfo& info = end.info;
  auto request_topic = dds::dds_request_name(info.name);
  auto reply_topic = dds::dds_reply_name(info.name);
  if (!request_topic) return err(request_topic.error());
  if (!reply_topic) return err(reply_topic.error());
  const std::string own_id = dds::endpoint_id_text(mirror.participant->gid(), ++last_id);
  dds::DdsQos qos = dds::service_qos(service_type_of(info));
  const auto options_for = [&](const std::string& topic, const msgs::MessageType& type) {
    dds::EndpointOptions with;
    with.topic = topic;
    with.type = type.dds_name;
    with.structure = type.hash;
    with.qos = qos;
    with.least_depth = kQueueOfService;
    const std::string data = dds::write_endpoint_user_data({.type_hash = type.hash,
                                                            .client_id = info.is_server ? std::string{} : own_id,
                                                            .service_id = info.is_server ? own_id : std::string{}});
    const ByteView bytes = as_bytes(data);
    with.user_data.assign(bytes.begin(), bytes.end());
    return with;
  };
  dds::EndpointOptions of_requests = options_for(*request_topic, *info.request);
  dds::EndpointOptions of_replies = options_for(*reply_topic, *info.response);
  dds::EndpointOptions& read = info.is_server ? of_requests : of_replies;
  read.qos.ignores_own_participant = true;
  auto reader = mirror.participant->create_reader(read, &end);
  if (!reader) return err(reader.error());
  auto writer = mirror.participant->create_writer(info.is_server ? of_replies : of_requests, &end);
  if (!writer) return err(writer.error());
  end.reader = std::move(*reader);
  end.writer = std::move(*writer);
  return {};
}

void DdsMirror::Impl::Services::take_gone(std::uint64_t id) {
  if (const auto server = servers.find(id); server != servers.end()) {
    hide(*server->second);
    replies_dropped += server->second->held.size();
    holding.erase(id);
    servers.erase(server);
  } else if (const auto client = clients.find(id); client != clients.end()) {
    hide(*client->second);
    settling.erase(id);
    clients.erase(client);
  }
  server_count = servers.size();
  client_count = clients.size();
}

void DdsMirror::Impl::Services::hide(const End& end) {
  mirror.hide(end.info.node, end.reader->gid(), false);
  mirror.hide(end.info.node, end.writer->gid(), true);
}

// --- matched peers ---------------------------------------------------------------------------------------------------

DdsMirror::Impl::Services::Peers DdsMirror::Impl::Services::peers_of(const End& end, bool are_writers) {
  const bool are_of_requests = are_writers == end.info.is_server;
  const msgs::MessageType& type = are_of_requests ? *end.info.request : *end.info.response;
  Peers met;
  for (const auto& peer : are_writers ? end.reader->matched() : end.writer->matched()) {
    const dds::Gid& gid = peer.endpoint.gid;
    if (gid.same_participant(mirror.participant->gid())) continue;
    const dds::EndpointUserData data = dds::read_endpoint_user_data(peer.endpoint.user_data);
    Peer& made = met[gid];
    made.id = end.info.is_server ? data.client_id : data.service_id;
    made.understands = data.type_hash.empty() || data.type_hash == type.hash;
    if (!made.understands) {
      tell_once(end, "hash " + data.type_hash,
                {"",
                 mirror.node_of(gid) + " has " + type.name + " as " + data.type_hash + ", this side as " + type.hash +
                     ": they do not hear each other",
                 "build both sides with the same message definitions"});
    } else if (dds::has_other_protocol(data)) {
      made.understands = false;
      tell_once(end, "protocol " + gid.participant().text(),
                {"",
                 mirror.node_of(gid) + (end.info.is_server ? " calls" : " offers") +
                     " it with another middleware than rmw_cyclonedds, whose services have another protocol: they do "
                     "not hear each other (topics do)",
                 "start it with RMW_IMPLEMENTATION=rmw_cyclonedds_cpp"});
    }
  }
  return met;
}

void DdsMirror::Impl::Services::tell_once(const End& end, const std::string& what, Problem problem) {
  problem.where = "service " + end.info.name;
  problem.code = dds::NetworkFault::ServiceUnusable;
  problem.value = end.info.name;
  mirror.tell_once("service " + end.info.name + " " + what, problem);
}

void DdsMirror::Impl::Services::fill(MirrorStats& out) const {
  out.requests = requests;
  out.requests_refused = requests_refused;
  out.replies = replies;
  out.replies_dropped = replies_dropped;
  out.calls = calls;
  out.answers = answers;
  out.calls_failed = calls_failed;
  out.late = late;
  out.clock_questions = clock_questions;
  out.clock_answers = clock_answers;
  out.servers = server_count;
  out.clients = client_count;
}

}  // namespace nacelle
