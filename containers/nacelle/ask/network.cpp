// SPDX-License-Identifier: Apache-2.0
#include "ask/network.hpp"

#include <utility>

namespace nacelle::ask {
namespace {

using nlohmann::json;

void unwrap_or_null(json& list) {
  json value = list.empty() ? json(nullptr) : std::move(list.front());
  list = std::move(value);
}

Result<json, Problem> network_of(Result<json, Problem> answer) {
  if (!answer) return answer;
  if (!answer.value()["success"].get<bool>()) return err(problem_of(answer.value()));
  json network = std::move(answer.value()["network"]);
  network["container"] = std::move(answer.value()["container"]);
  for (const char* const key : {"security", "problem", "figures"}) unwrap_or_null(network[key]);
  if (!network["security"].is_null())
    for (const char* const key : {"subject", "ends"}) unwrap_or_null(network["security"][key]);
  for (json& rule : network["exports"])
    for (const char* const key : {"max_hz", "max_bytes"}) unwrap_or_null(rule[key]);
  return network;
}

}  // namespace

Result<json, Problem> get_network(Nodes& nodes, const std::string& container) {
  return network_of(nodes.ask_container(container, "get_network", "nacelle_interfaces/srv/GetNetwork"));
}

Result<json, Problem> set_network(Nodes& nodes, const std::string& container, bool exported) {
  return network_of(
      nodes.ask_container(container, "set_network", "nacelle_interfaces/srv/SetNetwork", {{"exported", exported}}));
}

}  // namespace nacelle::ask
