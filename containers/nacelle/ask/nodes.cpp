// SPDX-License-Identifier: Apache-2.0
#include "nacelle/ask/nodes.hpp"

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

std::vector<bool> Nodes::prepare(const std::vector<std::pair<std::string, const char*>>& services) {
  json names = json::array();
  for (const auto& [service, type] : services) names.push_back({{"service", service}, {"type", type}});
  const auto reply = client_.call({{"verb", "service.prepare"}, {"services", names}}, limit_ + on_the_way_);
  std::vector<bool> offered(services.size(), false);
  if (reply) reply.value()["offered"].get_to(offered);
  return offered;
}

}  // namespace nacelle::ask
