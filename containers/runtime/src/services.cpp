// SPDX-License-Identifier: Apache-2.0
#include "services.hpp"

#include <algorithm>
#include <utility>

#include "message_library.hpp"

namespace nacelle::runtime {

void ServiceDirectory::add(const std::string& name, const std::string& node, ServerPort& server) {
  pin_library_of(server.request_type());
  pin_library_of(server.response_type());
  auto ends = ends_.lock();
  const auto made = ends->servers.emplace(name, Server{&server, ++ends->last_id, node});
  for (ServiceListener* const listener : ends->listeners) listener->on_made(info_of(name, made->second));
}

void ServiceDirectory::remove(const std::string& name, ServerPort& server) {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  const auto found = std::find_if(first, last, [&](const auto& entry) { return entry.second.port == &server; });
  if (found == last) return;
  const std::uint64_t id = found->second.id;
  ends->servers.erase(found);
  for (ServiceListener* const listener : ends->listeners) listener->on_gone(id);
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
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  for (auto it = first; it != last; ++it) {
    ServerPort& server = *it->second.port;
    if (&server.request_type() != &request || !server.is_open()) continue;
    server.push(std::move(call));
    return true;
  }
  const auto asks = ends->clients.find(client);
  if (asks == ends->clients.end() || asks->second.remote == nullptr) return false;
  return asks->second.remote->take(std::move(call));
}

bool ServiceDirectory::is_ready(const std::string& name, const msgs::MessageType& request, std::uint64_t client) const {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  const bool here = std::any_of(first, last, [&](const auto& entry) {
    return &entry.second.port->request_type() == &request && entry.second.port->is_open();
  });
  if (here) return true;
  const auto asks = ends->clients.find(client);
  return asks != ends->clients.end() && asks->second.remote != nullptr;
}

bool ServiceDirectory::is_ready(const std::string& name) const {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  return std::any_of(first, last, [](const auto& entry) { return entry.second.port->is_open(); });
}

Problem ServiceDirectory::why_not(const std::string& name, const msgs::MessageType& request) const {
  auto ends = ends_.lock();
  const auto [first, last] = ends->servers.equal_range(name);
  std::vector<std::string> others;
  for (auto it = first; it != last; ++it) {
    const msgs::MessageType& type = it->second.port->request_type();
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

ServiceEndInfo ServiceDirectory::info_of(const std::string& name, const Server& server) {
  return {server.id, true, name, server.node, &server.port->request_type(), &server.port->response_type()};
}

void ServiceDirectory::join(ServiceListener& listener) {
  auto ends = ends_.lock();
  ends->listeners.push_back(&listener);
  for (const auto& [name, server] : ends->servers) listener.on_made(info_of(name, server));
  for (const auto& [id, client] : ends->clients) listener.on_made(client.info);
}

void ServiceDirectory::leave(ServiceListener& listener) { std::erase(ends_.lock()->listeners, &listener); }

void ServiceDirectory::set_remote(std::uint64_t client, RemoteServer* server) {
  auto ends = ends_.lock();
  const auto found = ends->clients.find(client);
  if (found != ends->clients.end()) found->second.remote = server;
}

ServiceGraph::Sent ServiceDirectory::send(std::uint64_t server, Call call) {
  auto ends = ends_.lock();
  const auto found = std::find_if(ends->servers.begin(), ends->servers.end(),
                                  [&](const auto& entry) { return entry.second.id == server; });
  if (found == ends->servers.end()) return Sent::Gone;
  if (!found->second.port->is_open()) return Sent::Closed;
  found->second.port->push(std::move(call));
  return Sent::Yes;
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
