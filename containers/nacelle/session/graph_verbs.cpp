// SPDX-License-Identifier: Apache-2.0
#include "nacelle/session/graph_verbs.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "nacelle/ask/parameters.hpp"
#include "nacelle/control/client.hpp"
#include "nacelle/node/standard_interfaces.hpp"
#include "nacelle/qos/text.hpp"
#include "nacelle/session/load_request.hpp"
#include "nacelle/session/session.hpp"

namespace nacelle::session {
namespace {

using control::reply_of;
using nlohmann::json;

/// Seconds, or null for "for ever".
json seconds_or_null(Duration time) { return time == Duration::zero() ? json(nullptr) : json(to_seconds(time)); }

json to_json(const runtime::EndpointReport& end) {
  json row{{"topic", end.topic},
           {"type", end.type},
           {"hash", end.type_hash},
           {"node", end.node},
           {"id", end.id},
           {"publisher", end.is_writer},
           {"standard", is_standard_topic(end.topic)},
           {"elsewhere", end.in_other_process},
           {"qos", json_of(end.qos)}};
  if (end.command_timeout.after > Duration::zero()) {
    row["command_timeout_s"] = to_seconds(end.command_timeout.after);
    row["command_parameter"] = end.command_timeout.parameter;
  }
  return row;
}

bool is_isolated(Session& session, const runtime::ComponentInfo& info) {
  return !session.container().request_of(info.id).has_value();
}

json node_row(Session& session, const runtime::ComponentInfo& info) {
  return {{"node", info.node},       {"id", info.id},
          {"managed", info.managed}, {"state", info.managed ? nacelle::to_text(info.state) : ""},
          {"plugin", info.plugin},   {"isolated", is_isolated(session, info)},
          {"hidden", false}};
}

/// A node that is no component: the container's own, or one of a tool's.
json other_row(const std::string& node, bool hidden) {
  return {{"node", node}, {"id", 0},           {"managed", false}, {"state", ""},
          {"plugin", ""}, {"isolated", false}, {"hidden", hidden}};
}

json thread_of(const runtime::ThreadPolicy& thread) {
  return {{"own", thread.own}, {"threads", thread.threads}, {"priority", thread.priority}, {"cpus", thread.cpus}};
}

json texts_of_parameters(const std::map<std::string, ParameterValue>& parameters) {
  json all = json::object();
  for (const auto& [name, value] : parameters) all[name] = ask::json_of(value);
  return all;
}

json callbacks_of(Session& session, const std::string& node) {
  std::vector<runtime::CallbackReport> callbacks;
  session.container().report_callbacks(callbacks);
  json rows = json::array();
  for (const auto& callback : callbacks) {
    if (callback.node != node) continue;
    rows.push_back({{"kind", callback.kind}, {"name", callback.name}, {"count", callback.count}});
  }
  return rows;
}

json faults_of(Session& session, const std::string& node) {
  json rows = json::array();
  for (const auto& fault : session.container().faults()) {
    if (fault.node != node) continue;
    rows.push_back({{"code", fault.code},
                    {"text", fault.text},
                    {"callback", fault.callback},
                    {"time_s", static_cast<double>(fault.when.nanoseconds()) * 1e-9}});
  }
  return rows;
}

}  // namespace

json json_of(const QoS& qos) {
  return {{"reliability", to_text(qos.reliability())},
          {"history", to_text(qos.history())},
          {"depth", qos.depth()},
          {"durability", to_text(qos.durability())},
          {"lifespan_s", seconds_or_null(qos.lifespan())},
          {"deadline_s", seconds_or_null(qos.deadline())},
          {"liveliness", to_text(qos.liveliness())},
          {"liveliness_lease_s", seconds_or_null(qos.liveliness_lease_duration())}};
}

json graph_of(Session& session) {
  const runtime::Container& container = session.container();
  std::set<std::string> known;
  json nodes = json::array(), endpoints = json::array(), services = json::array();
  for (const auto& info : container.list()) {
    nodes.push_back(node_row(session, info));
    known.insert(info.node);
  }
  const auto note = [&](const std::string& node, bool hidden) {
    if (known.insert(node).second) nodes.push_back(other_row(node, hidden));
  };
  for (const auto& service : container.services()) {
    note(service.node, !service.name.starts_with(service.node + "/_container/"));
    services.push_back({{"name", service.name},
                        {"type", service.type},
                        {"node", service.node},
                        {"server", service.is_server},
                        {"open", service.open},
                        {"standard", service.is_standard}});
  }
  for (const auto& end : container.endpoints()) {
    note(end.node, true);
    endpoints.push_back(to_json(end));
  }
  return {{"ok", true},
          {"container", session.options().container_name},
          {"nodes", nodes},
          {"endpoints", endpoints},
          {"services", services}};
}

json component_info(Session& session, const json& request) {
  auto component = session.container().find(request.value("name", ""));
  if (!component) return reply_of(component.error());
  const runtime::ComponentInfo& info = component.value();
  json reply = node_row(session, info);
  reply["ok"] = true;
  reply["library"] = info.library;
  reply["state_id"] = static_cast<int>(info.state);
  if (!info.fault.code.empty()) reply["fault"] = {{"code", info.fault.code}, {"text", info.fault.text}};
  for (const auto& fault : info.open_faults)
    reply["open_faults"].push_back({{"code", fault.code}, {"text", fault.text}});
  reply["faults"] = faults_of(session, info.node);
  reply["actuator"] = info.actuator;
  reply["callbacks"] = callbacks_of(session, info.node);
  reply["namespace"] = info.node.rfind('/') == 0 ? "/" : info.node.substr(0, info.node.rfind('/'));
  // Of another process: as the launch file has it.
  std::optional<runtime::LoadRequest> given = session.container().request_of(info.id);
  if (const auto* const plan = session.plan().find(info.node); !given && plan != nullptr)
    given = load_request_of(*plan);
  if (!given) return reply;
  reply["remaps"] = json::array();
  for (const auto& rule : given->remaps) reply["remaps"].push_back(to_text(rule));
  reply["qos_overrides"] = json::array();
  for (const auto& qos : given->qos)
    reply["qos_overrides"].push_back({{"topic", qos.topic}, {"publisher", qos.for_publisher}});
  reply["parameters"] = texts_of_parameters(given->parameters);
  reply["thread"] = thread_of(given->thread);
  reply["on_fault"] = {{"policy", runtime::words_of(given->on_fault.policy_for(info.actuator))},
                       {"max_restarts", given->on_fault.max_restarts},
                       {"backoff_s", to_seconds(given->on_fault.backoff)}};
  return reply;
}

}  // namespace nacelle::session
