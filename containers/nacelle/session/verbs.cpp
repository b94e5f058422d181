// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/verbs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "nacelle/control/client.hpp"
#include "nacelle/session/figures_verb.hpp"
#include "nacelle/session/graph_verbs.hpp"
#include "nacelle/session/network_verbs.hpp"
#include "nacelle/session/service_verbs.hpp"
#include "nacelle/session/session.hpp"
#include "nacelle/session/tf_verbs.hpp"

namespace nacelle::session {
namespace {

using control::reply_of;
using nlohmann::json;

/// Where the launch's namespace has put what tools look for.
json names_of(const Session& session) {
  const launch::NamespacePlan& names = session.plan().name_space;
  return {
      {"ok", true}, {"namespace", names.path}, {"tf_topic", names.tf_topic()}, {"frame_prefix", names.frame_prefix()}};
}

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

json list_topics(Session& session) {
  std::vector<runtime::StreamReport> streams;
  session.container().report_streams(streams);
  json rows = json::array();
  for (const auto& stream : streams) {
    if (stream.writers == 0 && stream.readers == 0) continue;  // a stream that was
    rows.push_back({{"name", stream.name},
                    {"type", stream.type},
                    {"writers", stream.writers},
                    {"readers", stream.readers},
                    {"published", stream.published},
                    {"delivered", stream.delivered},
                    {"copies", stream.copies},
                    {"hz", stream.hz()}});
  }
  std::sort(rows.begin(), rows.end(),
            [](const json& a, const json& b) { return a["name"].get<std::string>() < b["name"].get<std::string>(); });
  return {{"ok", true}, {"topics", rows}};
}

/// Returns true for a service that is named after a question: GetState, ListParameters, DescribeParameters.
bool only_reads(const std::string& service_type) {
  const std::string_view name = std::string_view{service_type}.substr(service_type.rfind('/') + 1);
  return name.starts_with("Get") || name.starts_with("List") || name.starts_with("Describe");
}

bool changes_something(const std::string& verb, const json& request) {
  return verb == "service.call" && !only_reads(request.value("type", ""));
}

}  // namespace

Answer reply_to_verb(Session& session, msgs::TypeLibrary& types, const std::string& verb, const json& request) {
  if (changes_something(verb, request) && session.phase() != Phase::Running) {
    return reply_of({"container " + session.options().container_name, std::string{"it is "} + to_text(session.phase()),
                     "try again when it is running"});
  }
  if (verb == "faults") return session.faults();
  if (verb == "estop.list") return json{{"ok", true}, {"set", session.emergency_stops().set()}};
  if (verb == "topic.list") return list_topics(session);
  if (verb == "graph") return graph_of(session);
  if (verb == "component.info") return component_info(session, request);
  if (verb == "node.find") return find_node(session, request);
  if (verb == "container.find") return json{{"ok", true}, {"node", session.container().node()}, {"is_nacelle", true}};
  if (verb == "service.prepare") return offered_services(session, request);
  if (verb == "service.call") {
    const auto start = [&](const auto&... given) { return session.container().call_service(given...); };
    return call_service(session.container().clock(), start, types, request, "see `nacelle faults`");
  }
  if (verb == "figures") return figures_of(session);
  if (verb == "names") return names_of(session);
  if (verb == "tf.tree" || verb == "tf.lookup") return reply_to_tf_verb(session, verb, request);
  if (verb.starts_with("network")) return reply_to_network_verb(session, verb, request);
  if (verb == "shutdown") {
    session.request_shutdown();
    return json{{"ok", true}};
  }
  return reply_of(
      {"request '" + verb + "'", "is unknown to this container", "use the `nacelle` that started the container"});
}

}  // namespace nacelle::session
