// SPDX-License-Identifier: Apache-2.0
#include "remote/service_clients.hpp"

#include <algorithm>

namespace nacelle::remote {

const void* RemoteCall::response() const {
  auto answer = answer_.lock();
  return answer->response ? answer->response->get() : nullptr;
}

void RemoteCall::push(std::int64_t, std::unique_ptr<msgs::AnyMessage> response) {
  {
    auto answer = answer_.lock();
    answer->state = response ? State::Answered : State::Refused;
    answer->response = std::move(response);
  }
  on_answer_();
}

std::uint64_t ServiceClients::client_of(const std::string& service, const msgs::ServiceType& type) {
  auto ends = ends_.lock();
  const msgs::MessageType& request = type.request();
  for (const auto& [id, client] : ends->clients) {
    if (client.info.name == service && client.info.request == &request) return id;
  }
  const std::uint64_t id = ends->clients.size() + 1;
  const ServiceEndInfo info{id, false, service, node_, &request, &type.response()};
  ends->clients[id].info = info;
  for (ServiceListener* const listener : ends->listeners) listener->on_made(info);
  return id;
}

bool ServiceClients::is_ready(std::uint64_t client) const {
  auto ends = ends_.lock();
  const auto found = ends->clients.find(client);
  return found != ends->clients.end() && found->second.server != nullptr;
}

bool ServiceClients::call(std::uint64_t client, Call call) {
  auto ends = ends_.lock();
  const auto found = ends->clients.find(client);
  // Under the lock: after set_remote(null) no take() runs.
  return found != ends->clients.end() && found->second.server != nullptr && found->second.server->take(std::move(call));
}

void ServiceClients::join(ServiceListener& listener) {
  auto ends = ends_.lock();
  ends->listeners.push_back(&listener);
  for (const auto& [id, client] : ends->clients) listener.on_made(client.info);
}

void ServiceClients::leave(ServiceListener& listener) { std::erase(ends_.lock()->listeners, &listener); }

void ServiceClients::set_remote(std::uint64_t client, RemoteServer* server) {
  {
    auto ends = ends_.lock();
    const auto found = ends->clients.find(client);
    if (found != ends->clients.end()) found->second.server = server;
  }
  on_change_();
}

}  // namespace nacelle::remote
