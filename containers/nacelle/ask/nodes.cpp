// SPDX-License-Identifier: Apache-2.0
#include "ask/nodes.hpp"

#include "nacelle/base/problem_json.hpp"

namespace nacelle::ask {

using nlohmann::json;

Result<Nodes::Found, Problem> Nodes::locate(const std::string& name) {
  auto reply = client_.call({{"verb", "node.find"}, {"name", name}, {"with_container", true}}, limit_ + on_the_way_);
  if (!reply) return err(reply.error());
  return Found{reply.value()["node"], reply.value().value("container", "")};
}

Result<std::string, Problem> Nodes::find(const std::string& name) {
  auto reply = client_.call({{"verb", "node.find"}, {"name", name}}, limit_ + on_the_way_);
  if (!reply) return err(reply.error());
  return reply.value()["node"].get<std::string>();
}

Result<Nodes::FoundContainer, Problem> Nodes::container(const std::string& name) {
  auto reply = client_.call({{"verb", "container.find"}, {"name", name}}, limit_ + on_the_way_);
  if (!reply) return err(reply.error());
  return FoundContainer{reply.value()["node"], reply.value()["is_nacelle"]};
}

Result<json, Problem> Nodes::graph() { return client_.call({{"verb", "graph"}}, limit_ + on_the_way_); }

Result<json, Problem> Nodes::call(const std::string& service, const char* type, const json& request) {
  return call(service, type, request, limit_);
}

Result<json, Problem> Nodes::call(const std::string& service, const char* type, const json& request, Duration limit) {
  auto reply = client_.call({{"verb", "service.call"},
                             {"service", service},
                             {"type", type},
                             {"request", request},
                             {"timeout_s", to_seconds(limit)}},
                            limit + on_the_way_);
  if (!reply) return err(reply.error());
  return std::move(reply.value()["response"]);
}

Result<json, Problem> Nodes::ask_container(const std::string& name, const char* service, const char* type,
                                           const json& request) {
  const auto found = container(name);
  if (!found) return err(found.error());
  const std::string& node = found.value().node;
  if (!found.value().is_nacelle)
    return err(Problem{"container " + node, std::string{"has no service "} + service + ": it is not Nacelle's", ""});
  return call(service_of_container(node, service), type, request);
}

std::vector<bool> Nodes::prepare(const std::vector<std::pair<std::string, const char*>>& services) {
  json names = json::array();
  for (const auto& [service, type] : services) names.push_back({{"service", service}, {"type", type}});
  const auto reply = client_.call({{"verb", "service.prepare"}, {"services", names}}, limit_ + on_the_way_);
  std::vector<bool> offered(services.size(), false);
  if (reply) reply.value()["offered"].get_to(offered);
  return offered;
}

std::string service_of_container(const std::string& container, const char* name) {
  return container + "/_container/" + name;
}

Problem problem_of(const json& response) { return response.at("problem").get<Problem>(); }

void unwrap(json& message, const char* key) {
  json list = std::move(message.at(key));
  if (list.empty()) {
    message.erase(key);
  } else {
    message[key] = std::move(list.front());
  }
}

}  // namespace nacelle::ask
