// SPDX-License-Identifier: Apache-2.0
#include "answers/verbs.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "answers/graph_verbs.hpp"
#include "control/client.hpp"
#include "requests/service_verbs.hpp"

namespace nacelle::answers {
namespace {

using control::reply_of;
using nlohmann::json;

/// Answers with the full name of a component, or of another node here that offers a service.
json find_node(Robot& robot, const json& request) {
  const std::string name = request.value("name", "");
  const auto component = robot.container().find(name);
  if (component) return {{"ok", true}, {"node", component.value().node}, {"container", robot.container().node()}};
  for (const auto& service : robot.container().services()) {
    if (service.is_server && (service.node == name || service.node.ends_with("/" + name)))
      return {{"ok", true}, {"node", service.node}};
  }
  return reply_of(component.error());
}

/// Every server here is within reach: nothing has to be prepared.
json offered_services(Robot& robot, const json& request) {
  const auto services = robot.container().services();
  json offered = json::array();
  for (const auto& wanted : request.at("services")) {
    const auto& name = wanted.at("service").get_ref<const std::string&>();
    offered.push_back(
        std::ranges::any_of(services, [&](const auto& service) { return service.is_server && service.name == name; }));
  }
  return {{"ok", true}, {"offered", offered}};
}

/// Returns true for a service that is named after a question: GetState, ListParameters, DescribeParameters, LookupTransform.
bool only_reads(const std::string& service_type) {
  const std::string_view name = std::string_view{service_type}.substr(service_type.rfind('/') + 1);
  return std::ranges::any_of(std::array{"Get", "List", "Describe", "Lookup"},
                             [&](const char* verb) { return name.starts_with(verb); });
}

bool changes_something(const std::string& verb, const json& request) {
  return verb == "service.call" && !only_reads(request.value("type", ""));
}

}  // namespace

requests::Answer reply_to_verb(Robot& robot, msgs::TypeLibrary& types, const std::string& verb, const json& request) {
  if (changes_something(verb, request) && robot.phase() != Phase::Running) return reply_of(why_not_running(robot));
  if (verb == "graph") return graph_of(robot);
  if (verb == "node.find") return find_node(robot, request);
  if (verb == "container.find") return json{{"ok", true}, {"node", robot.container().node()}, {"is_nacelle", true}};
  if (verb == "service.prepare") return offered_services(robot, request);
  if (verb == "service.call") {
    const auto start = [&](const auto&... given) { return robot.container().call_service(given...); };
    return requests::call_service(robot.container().clock(), start, types, request, "see `nacelle faults`");
  }
  return reply_of(
      {"request '" + verb + "'", "is unknown to this container", "use the `nacelle` that started the container"});
}

}  // namespace nacelle::answers
