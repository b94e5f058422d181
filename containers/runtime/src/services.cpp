// SPDX-License-Identifier: Apache-2.0
#include "services.hpp"

#include <algorithm>
#include <utility>

#include "message_library.hpp"
#include "nacelle/host/standard_interfaces.hpp"

namespace nacelle::runtime {

bool ServiceDirectory::Server::is_open() const { return port != nullptr ? port->is_open() : info.is_open; }

bool ServiceDirectory::Server::take(Call call) const {
  if (port == nullptr) return remote->take(std::move(call));
  port->push(std::move(call));
  return true;
}

void ServiceDirectory::add(const std::string& name, const std::string& node, ServerPort& server) {
  pin_library_of(server.request_type());
  pin_library_of(server.response_type());
  auto ends = ends_.lock();
  Server made{{0, true, name, node, &server.request_type(), &server.response_type(), server.is_open()}, &server};
  add(*ends, std::move(made));
}

void ServiceDirectory::add(Ends& ends, Server server) {
  server.info.id = ++ends.last_id;
  const auto made = ends.servers.emplace(server.info.name, std::move(server));
  for (ServiceListener* const listener : ends.listeners) listener->on_made(made->second.info);
  tell_ready(ends, made->first);
}

void ServiceDirectory::remove(const std::string& name, ServerPort& server) {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  const auto found = std::find_if(first, last, [&](const auto& entry) { return entry.second.port == &server; });
  if (found != last) remove(*ends, found);
}

void ServiceDirectory::remove(Ends& ends, Servers::iterator server) {
  const ServiceEndInfo info = server->second.info;
  ends.servers.erase(server);
  for (ServiceListener* const listener : ends.listeners) listener->on_gone(info.id);
  tell_ready(ends, info.name);
}

void ServiceDirectory::note_gate(const std::string& name, const ServerPort& server) {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  const auto found = std::find_if(first, last, [&](const auto& entry) { return entry.second.port == &server; });
  if (found != last) tell_gate(*ends, found->second);
}

void ServiceDirectory::tell_gate(Ends& ends, Server& server) {
  const bool open = server.is_open();
  if (std::exchange(server.info.is_open, open) == open) return;
  for (ServiceListener* const listener : ends.listeners) listener->on_ready(server.info.id, server.info.is_open);
  tell_ready(ends, server.info.name);
}

void ServiceDirectory::tell_ready(Ends& ends, const std::string& name) {
  for (auto& [id, client] : ends.clients) {
    if (!client.is_stand_in || client.info.name != name) continue;
    const bool ready = client.remote != nullptr || is_offered(ends, name, *client.info.request);
    if (std::exchange(client.is_ready, ready) == ready) continue;
    for (ServiceListener* const listener : ends.listeners) listener->on_ready(id, ready);
  }
}

std::uint64_t ServiceDirectory::add_client(ServiceEndInfo client) {
  pin_library_of(*client.request);
  pin_library_of(*client.response);
  auto ends = ends_.lock();
  client.id = ++ends->last_id;
  client.is_server = false;
  for (ServiceListener* const listener : ends->listeners) listener->on_made(client);
  const std::uint64_t id = client.id;
  ends->clients.emplace(id, Client{std::move(client)});
  return id;
}

void ServiceDirectory::remove_client(std::uint64_t client) {
  auto ends = ends_.lock();
  if (ends->clients.erase(client) == 0) return;
  for (ServiceListener* const listener : ends->listeners) listener->on_gone(client);
}

bool ServiceDirectory::send(const std::string& name, const msgs::MessageType& request, Call call,
                            std::uint64_t client) {
  return send(*ends_.lock(), name, request, std::move(call), client);
}

bool ServiceDirectory::send(const Ends& ends, const std::string& name, const msgs::MessageType& request, Call call,
                            std::uint64_t client) {
  const auto [first, last] = ends.servers.equal_range(name);
  for (auto it = first; it != last; ++it) {
    if (it->second.info.request == &request && it->second.is_open()) return it->second.take(std::move(call));
  }
  const auto asks = ends.clients.find(client);
  if (asks == ends.clients.end() || asks->second.remote == nullptr) return false;
  return asks->second.remote->take(std::move(call));
}

bool ServiceDirectory::is_offered(const Ends& ends, const std::string& name, const msgs::MessageType& request) {
  const auto [first, last] = ends.servers.equal_range(name);
  return std::any_of(
      first, last, [&](const auto& entry) { return entry.second.info.request == &request && entry.second.is_open(); });
}

bool ServiceDirectory::is_ready(const std::string& name, const msgs::MessageType& request, std::uint64_t client) const {
  auto ends = ends_.lock();
  if (is_offered(*ends, name, request)) return true;
  const auto asks = ends->clients.find(client);
  return asks != ends->clients.end() && asks->second.remote != nullptr;
}

bool ServiceDirectory::is_ready(const std::string& name) const {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  return std::any_of(first, last, [](const auto& entry) { return entry.second.is_open(); });
}

void ServiceDirectory::report_stand_ins(std::vector<ServiceReport>& out) const {
  auto ends = ends_.lock();
  for (const auto& [name, server] : ends->servers) {
    if (server.port != nullptr) continue;
    const auto standard = standard_services(server.info.node, true);
    out.push_back({name, service_type_of(*server.info.request), server.info.node, true, server.is_open(),
                   std::ranges::find(standard, name) != standard.end()});
  }
  for (const auto& [id, client] : ends->clients) {
    if (client.is_stand_in)
      out.push_back({client.info.name, service_type_of(*client.info.request), client.info.node, false, true});
  }
}

Problem ServiceDirectory::why_not(const std::string& name, const msgs::MessageType& request) const {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  std::vector<std::string> others;
  for (auto it = first; it != last; ++it) {
    const msgs::MessageType& type = *it->second.info.request;
    if (&type == &request && it->second.is_open())
      return {"service " + name, "takes no more calls: too many wait for an answer, or the request is too long",
              "see `nacelle top` for what its node is busy with"};
    if (&type == &request) return {"service " + name, "its node is not active", "see `nacelle lifecycle nodes`"};
    others.push_back(service_type_of(type));
  }
  if (!others.empty())
    return {"service " + name, "has the type " + nacelle::join(others, " and ") + ", not " + service_type_of(request),
            ""};
  std::vector<std::string> names;
  for (const auto& [other, server] : ends->servers) names.push_back(other);
  return {"service " + name, "no node of this process offers it", suggestion(name, names)};
}

void ServiceDirectory::join(ServiceListener& listener) {
  auto ends = ends_.lock();
  ends->listeners.push_back(&listener);
  for (const auto& [name, server] : ends->servers) listener.on_made(server.info);
  for (const auto& [id, client] : ends->clients) listener.on_made(client.info);
}

void ServiceDirectory::leave(ServiceListener& listener) { std::erase(ends_.lock()->listeners, &listener); }

void ServiceDirectory::set_remote(std::uint64_t client, RemoteServer* server) {
  auto ends = ends_.lock();
  const auto found = ends->clients.find(client);
  if (found == ends->clients.end()) return;
  found->second.remote = server;
  tell_ready(*ends, found->second.info.name);
}

ServiceDirectory::Servers::iterator ServiceDirectory::find_server(Ends& ends, std::uint64_t id) {
  return std::find_if(ends.servers.begin(), ends.servers.end(),
                      [&](const auto& entry) { return entry.second.info.id == id; });
}

ServiceGraph::Sent ServiceDirectory::send(std::uint64_t server, Call call) {
  auto ends = ends_.lock();
  const auto found = find_server(*ends, server);
  if (found == ends->servers.end()) return Sent::Gone;
  if (!found->second.is_open()) return Sent::Closed;
  return found->second.take(std::move(call)) ? Sent::Yes : Sent::Full;
}

std::uint64_t ServiceDirectory::add_stand_in(ServiceEndInfo end, RemoteServer* server) {
  pin_library_of(*end.request);
  pin_library_of(*end.response);
  auto ends = ends_.lock();
  if (end.is_server) {
    add(*ends, Server{std::move(end), nullptr, server});
    return ends->last_id;
  }
  const std::uint64_t id = end.id = ++ends->last_id;
  for (ServiceListener* const listener : ends->listeners) listener->on_made(end);
  const std::string name = end.name;
  ends->clients.emplace(id, Client{std::move(end), nullptr, true});
  tell_ready(*ends, name);
  return id;
}

void ServiceDirectory::open_stand_in(std::uint64_t server, bool open) {
  auto ends = ends_.lock();
  const auto found = find_server(*ends, server);
  if (found == ends->servers.end() || std::exchange(found->second.info.is_open, open) == open) return;
  for (ServiceListener* const listener : ends->listeners) listener->on_ready(server, open);
  tell_ready(*ends, found->first);
}

void ServiceDirectory::remove_stand_in(std::uint64_t id) {
  {
    auto ends = ends_.lock();
    if (const auto found = find_server(*ends, id); found != ends->servers.end()) return remove(*ends, found);
  }
  remove_client(id);
}

bool ServiceDirectory::call(std::uint64_t client, Call call) {
  auto ends = ends_.lock();
  const auto asks = ends->clients.find(client);
  if (asks == ends->clients.end()) return false;
  const ServiceEndInfo& info = asks->second.info;
  return send(*ends, info.name, *info.request, std::move(call), client);
}

std::string service_type_of(const msgs::MessageType& request) {
  constexpr std::string_view kEnding = "_Request";
  std::string name = request.name;
  if (name.ends_with(kEnding)) name.resize(name.size() - kEnding.size());
  return name;
}

void ServerPort::push(Call call) {
  const MonotonicTime now = clock_.now();
  auto calls = calls_.lock();
  calls->push_back({std::move(call), now});
  waiting_.store(calls->size(), std::memory_order_release);
  on_ready();  // under the lock: docs/wake_up.md, rule 2
}

void ServerPort::execute(MonotonicTime now) {
  std::list<Waiting> taken;
  {
    auto calls = calls_.lock();
    if (calls->empty()) return;
    taken.splice(taken.begin(), *calls, calls->begin());
    waiting_.store(calls->size(), std::memory_order_release);
    if (stats_) stats_->latency.record(now - taken.front().since);
    // In a reentrant group the next call need not wait for this one's callback.
    if (!calls->empty() && group().type() == CallbackGroupType::Reentrant) on_ready();
  }
  const Call& call = taken.front().call;
  if (!is_open()) {
    call.asker.answer(nullptr);
    return;
  }
  std::int64_t number = 0;
  {
    auto open = open_calls_.lock();
    number = ++open->last;
    open->calls.emplace(number, call.asker);
  }
  auto response = std::make_unique<AnyMessage>(response_);
  try {
    if (!callback_.run(callback_.context, number, call.request.get(), response->get())) return;
  } catch (...) {
    answer_open(number, nullptr);
    throw;  // the executor makes it the component's fault
  }
  answer_open(number, std::move(response));
}

bool ServerPort::answer_open(std::int64_t call, std::unique_ptr<AnyMessage> response) {
  // The caller may have its answer already, or the notice that there will be none.
  const auto taken = open_calls_.lock()->calls.extract(call);
  return !taken.empty() && taken.mapped().answer(std::move(response));
}

bool ServerPort::send_response(std::int64_t call, void* response) {
  auto moved = std::make_unique<AnyMessage>(response_);
  response_.move_assign(moved->get(), response);
  return answer_open(call, std::move(moved));
}

void ServerPort::refuse_all() {
  std::list<Waiting> waiting;
  {
    auto calls = calls_.lock();
    calls->swap(waiting);
    waiting_.store(0, std::memory_order_release);
  }
  std::map<std::int64_t, Asker> open;
  open_calls_.lock()->calls.swap(open);
  for (const auto& entry : open) entry.second.answer(nullptr);
  for (const Waiting& refused : waiting) refused.call.asker.answer(nullptr);
}

void ClientPort::push(std::int64_t sequence, std::unique_ptr<AnyMessage> response) {
  const MonotonicTime now = clock_.now();
  auto answers = answers_.lock();
  answers->push_back({sequence, std::move(response), now});
  waiting_.store(answers->size(), std::memory_order_release);
  on_ready();
}

void ClientPort::execute(MonotonicTime now) {
  Answer next{};
  {
    auto answers = answers_.lock();
    if (answers->empty()) return;
    next = std::move(answers->front());
    answers->pop_front();
    waiting_.store(answers->size(), std::memory_order_release);
    stats_.latency.record(now - next.since);
    if (!answers->empty() && group().type() == CallbackGroupType::Reentrant) on_ready();
  }
  callback_.run(callback_.context, next.sequence, next.response ? next.response->get() : nullptr);
}

}  // namespace nacelle::runtime
