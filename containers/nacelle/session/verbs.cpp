// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/verbs.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "nacelle/control/client.hpp"
#include "nacelle/desk/service_verbs.hpp"
#include "nacelle/session/graph_verbs.hpp"
#include "nacelle/session/session.hpp"

namespace nacelle::session {
namespace {

using control::reply_of;
using nlohmann::json;

/// Answers with the full name of a component, or of another node here that offers a service.
json find_node(Session& session, const json& request) {
  const std::string name = request.value("name", "");
  const auto component = session.container().find(name);
  if (component) return {{"ok", true}, {"node", component.value().node}, {"container", session.container().node()}};
  for (const auto& service : session.container().services()) {
    if (service.is_server && (service.node == name || service.node.ends_with("/" + name)))
      return {{"ok", true}, {"node", service.node}};
  }
  return reply_of(component.error());
}

/// Every server here is within reach: nothing has to be prepared.
json offered_services(Session& session, const json& request) {
  const auto services = session.container().services();
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

desk::Answer reply_to_verb(Session& session, msgs::TypeLibrary& types, const std::string& verb, const json& request) {
  if (changes_something(verb, request) && session.phase() != Phase::Running) {
    return reply_of({"container " + session.options().container_name, std::string{"it is "} + to_text(session.phase()),
                     "try again when it is running"});
  }
  if (verb == "graph") return graph_of(session);
  if (verb == "node.find") return find_node(session, request);
  if (verb == "container.find") return json{{"ok", true}, {"node", session.container().node()}, {"is_nacelle", true}};
  if (verb == "service.prepare") return offered_services(session, request);
  if (verb == "service.call") {
    const auto start = [&](const auto&... given) { return session.container().call_service(given...); };
    return desk::call_service(session.container().clock(), start, types, request, "see `nacelle faults`");
  }
  return reply_of(
      {"request '" + verb + "'", "is unknown to this container", "use the `nacelle` that started the container"});
}

}  // namespace nacelle::session
