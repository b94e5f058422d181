// SPDX-License-Identifier: Apache-2.0
#include "ask/composition.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "ask/parameters.hpp"
#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/launch/parameter_file.hpp"

namespace nacelle::ask {
namespace {

using nlohmann::json;

constexpr const char* kGetComponent = "nacelle_interfaces/srv/GetComponent";
constexpr const char* kGetComponents = "nacelle_interfaces/srv/GetComponents";
constexpr const char* kLoadComponent = "nacelle_interfaces/srv/LoadComponent";
constexpr const char* kUnloadComponent = "nacelle_interfaces/srv/UnloadComponent";
constexpr const char* kChangeState = "nacelle_interfaces/srv/ChangeState";
constexpr const char* kListNodes = "composition_interfaces/srv/ListNodes";
constexpr const char* kLoadNode = "composition_interfaces/srv/LoadNode";
constexpr const char* kUnloadNode = "composition_interfaces/srv/UnloadNode";
constexpr const char* kGetState = "lifecycle_msgs/srv/GetState";
constexpr const char* kNodesChangeState = "lifecycle_msgs/srv/ChangeState";

// A component may take its time to find its device; the container gives it up after half a minute.
constexpr Duration kTransition = 80s;

std::string text_of(const json& row, const char* key) { return row.at(key).get<std::string>(); }

/// nacelle_interfaces/msg/Component as a row for people and scripts.
json row_of(json component) {
  unwrap(component, "fault");
  for (const char* const list : {"open_faults", "other_nodes"}) {
    if (component[list].empty()) component.erase(list);
  }
  component["state"] = component["managed"].get<bool>() ? json(component["state"]["label"]) : json("");
  return component;
}

Result<json, Problem> components_of(Nodes& nodes, const std::string& container) {
  return nodes.call(service_of_container(container, "get_components"), kGetComponents, json::object());
}

// --- of containers that are not Nacelle's ----------------------------------------------------------------------------

Result<json, Problem> members_of(Nodes& nodes, const std::string& container) {
  const auto answer = nodes.call(service_of_container(container, "list_nodes"), kListNodes, json::object());
  if (!answer) return err(answer.error());
  const json& names = answer.value()["full_node_names"];
  const json& ids = answer.value()["unique_ids"];
  json rows = json::array();
  for (std::size_t i = 0; i < std::min(names.size(), ids.size()); ++i)
    rows.push_back({{"id", ids[i]}, {"node", names[i]}});
  return rows;
}

/// By its full name, its id, or its name without the namespace if there is one such.
Result<json, Problem> row_named(const json& rows, const std::string& name, const std::string& container) {
  std::vector<std::string> names, hits;
  const json* hit = nullptr;
  for (const json& row : rows) {
    const std::string node = text_of(row, "node");
    if (node == name || node == "/" + name || row["id"].dump() == name) return json(row);
    names.push_back(node);
    if (name.starts_with('/') || !node.ends_with("/" + name)) continue;
    hits.push_back(node);
    hit = &row;
  }
  if (hits.size() == 1) return json(*hit);
  const std::string what = "component '" + name + "'";
  if (!hits.empty())
    return err(
        Problem{what, "could be any of " + join(hits), "give the full name or the id", NameFault::Ambiguous, name});
  return err(Problem{what, "is not in " + container, names.empty() ? "it holds none" : suggestion(name, names),
                     NameFault::Unknown, name});
}

Result<json, Problem> list_members(Nodes& nodes, const std::string& container) {
  auto rows = members_of(nodes, container);
  if (!rows) return rows;
  std::vector<std::pair<std::string, const char*>> services;
  for (const json& row : rows.value()) services.emplace_back(text_of(row, "node") + "/get_state", kGetState);
  const std::vector<bool> offered = nodes.prepare(services);
  for (std::size_t i = 0; i < services.size(); ++i) {
    const auto state = offered[i] ? nodes.call(services[i].first, kGetState, json::object()) : err(Problem{});
    rows.value()[i].update({{"plugin", ""},
                            {"library", ""},
                            {"managed", static_cast<bool>(offered[i])},
                            {"state", state ? state.value()["current_state"]["label"] : json("")}});
  }
  return json{{"container", container.substr(1)}, {"components", rows.value()}, {"kept_images", json::array()}};
}

// --- what is to be loaded --------------------------------------------------------------------------------------------

/// The fields that LoadNode and LoadComponent share. `below`: the namespace of a relative one.
Result<json, Problem> request_of(const LoadWish& wish, const std::string& below) {
  std::map<std::string, ParameterValue> values;
  // The file first, single values over it: as ros2 component load does.
  if (!wish.parameters_file.empty()) {
    auto parsed = launch::parse_parameter_file(wish.parameters_text, wish.parameters_file);
    if (!parsed) return err(parsed.error().front());
    const std::string node = fully_qualified_node_name(join_namespaces(below, wish.name_space), wish.name);
    for (const auto& parameter : parsed.value().parameters_for(node)) values[parameter.name] = parameter.value;
  }
  for (const auto& text : wish.parameters) {
    auto parameter = launch::parse_parameter_assignment(text);
    if (!parameter) return err(Problem{"-p " + text, parameter.error().what, parameter.error().way_out});
    values[parameter.value().first] = parameter.value().second;
  }
  json parameters = json::array(), remaps = json::array();
  for (const auto& [name, value] : values) parameters.push_back({{"name", name}, {"value", message_of(value)}});
  for (const auto& text : wish.remaps) {
    auto rule = parse_remap_rule(text);
    if (!rule) return err(Problem{"-r " + text, rule.error().what, rule.error().way_out});
    remaps.push_back(to_text(rule.value()));
  }
  return json{{"node_name", wish.name},
              {"node_namespace", wish.name_space},
              {"parameters", parameters},
              {"remap_rules", remaps}};
}

Result<json, Problem> load_member(Nodes& nodes, const std::string& container, const LoadWish& wish) {
  if (wish.component.find("::") == std::string::npos) {
    return err(Problem{"component " + wish.component, container + " has no launch file of Nacelle's",
                       "load a plugin: pkg::Class --name N"});
  }
  auto request = request_of(wish, "/");
  if (!request) return err(request.error());
  // A class is taken to be in the package of its first namespace.
  request.value()["package_name"] = wish.component.substr(0, wish.component.find("::"));
  request.value()["plugin_name"] = wish.component;
  const auto answer = nodes.call(service_of_container(container, "load_node"), kLoadNode, request.value(), kTransition);
  if (!answer) return err(answer.error());
  if (!answer.value()["success"].get<bool>())
    return err(Problem{container, text_of(answer.value(), "error_message"), ""});
  return json{{"id", answer.value()["unique_id"]},
              {"node", answer.value()["full_node_name"]},
              {"plugin", wish.component},
              {"library", ""},
              {"managed", false},
              {"state", ""},
              {"warnings", json::array()}};
}

Result<json, Problem> unload_member(Nodes& nodes, const std::string& container, const std::string& name) {
  const auto rows = members_of(nodes, container);
  if (!rows) return err(rows.error());
  const auto row = row_named(rows.value(), name, container);
  if (!row) return err(row.error());
  const auto done = nodes.call(service_of_container(container, "unload_node"), kUnloadNode,
                               {{"unique_id", row.value()["id"]}}, kTransition);
  if (!done) return err(done.error());
  if (!done.value()["success"].get<bool>()) return err(Problem{container, text_of(done.value(), "error_message"), ""});
  return json{{"id", row.value()["id"]},
              {"node", row.value()["node"]},
              {"library", ""},
              {"image_closed", true},
              {"held_by", ""}};
}

// --- states ----------------------------------------------------------------------------------------------------------

Problem without_lifecycle(const std::string& node) {
  return {node, "is a plain node without a lifecycle", "see `nacelle lifecycle nodes`"};
}

Result<json, Problem> state_of(Nodes& nodes, const std::string& node) {
  const auto answer = nodes.call(node + "/get_state", kGetState, json::object());
  if (!answer) return err(answer.error());
  return json(answer.value()["current_state"]);
}

/// The details of nacelle_interfaces/srv/GetComponent.
json info_of(json response) {
  json info = row_of(response["component"]);
  info["state_id"] = response["component"]["state"]["id"];
  info["container"] = text_of(response, "container").substr(1);
  for (const char* const key : {"host", "isolated", "actuator", "callbacks"}) info[key] = std::move(response[key]);
  info["faults"] = json::array();
  for (const json& fault : response["faults"]) {
    info["faults"].push_back({{"code", fault["code"]},
                              {"text", fault["text"]},
                              {"callback", fault["callback"]},
                              {"time_s", fault["time_ns"].get<double>() * 1e-9}});
  }
  for (json& load : response["load"]) {
    info["parameters"] = json::object();
    for (const json& parameter : load["parameters"])
      info["parameters"][text_of(parameter, "name")] = json_of(value_of(parameter["value"]));
    info["remaps"] = std::move(load["remap_rules"]);
    for (const char* const key : {"qos_overrides", "thread", "on_fault"}) info[key] = std::move(load[key]);
  }
  return info;
}

/// The same of a component that another container holds.
Result<json, Problem> info_of_member(Nodes& nodes, const std::string& container, const std::string& name) {
  auto row = find_component(nodes, container, name);
  if (!row) return row;
  json& info = row.value();
  info.erase("plugin");
  info.erase("library");
  info["state_id"] = 0;
  if (!info["managed"].get<bool>()) return row;
  const auto state = state_of(nodes, text_of(info, "node"));
  if (!state) return err(state.error());
  info["state"] = state.value()["label"];
  info["state_id"] = state.value()["id"];
  return row;
}

}  // namespace

Result<json, Problem> list_components(Nodes& nodes, const std::string& container) {
  const auto found = nodes.container(container);
  if (!found) return err(found.error());
  if (!found.value().is_nacelle) return list_members(nodes, found.value().node);
  auto answer = components_of(nodes, found.value().node);
  if (!answer) return err(answer.error());
  json rows = json::array();
  for (auto& component : answer.value()["components"]) rows.push_back(row_of(std::move(component)));
  return json{{"container", text_of(answer.value(), "container").substr(1)},
              {"components", rows},
              {"kept_images", std::move(answer.value()["kept_images"])}};
}

Result<json, Problem> find_component(Nodes& nodes, const std::string& container, const std::string& name) {
  const auto all = list_components(nodes, container);
  if (!all) return err(all.error());
  auto row = row_named(all.value()["components"], name, "/" + text_of(all.value(), "container"));
  if (!row) return err(row.error());
  row.value()["container"] = all.value()["container"];
  return row;
}

Result<json, Problem> component_info(Nodes& nodes, const std::string& container, const std::string& name) {
  const auto found = nodes.container(container);
  if (!found) return err(found.error());
  const std::string& holder = found.value().node;
  auto info = found.value().is_nacelle
                  ? nodes.call(service_of_container(holder, "get_component"), kGetComponent, {{"component", name}})
                  : info_of_member(nodes, holder, name);
  if (!info) return info;
  if (found.value().is_nacelle) {
    if (!info.value()["success"].get<bool>()) return err(problem_of(info.value()));
    info = info_of(std::move(info).value());
  }
  const std::string node = text_of(info.value(), "node");
  info.value()["namespace"] = node.rfind('/') == 0 ? "/" : node.substr(0, node.rfind('/'));
  return info;
}

Result<json, Problem> load_component(Nodes& nodes, const std::string& container, const LoadWish& wish) {
  const auto found = nodes.container(container);
  if (!found) return err(found.error());
  const std::string& node = found.value().node;
  if (!found.value().is_nacelle) return load_member(nodes, node, wish);
  std::string below = "/";
  if (!wish.parameters_file.empty()) {
    const auto told = components_of(nodes, node);
    if (!told) return err(told.error());
    below = text_of(told.value(), "name_space");
  }
  auto request = request_of(wish, below);
  if (!request) return err(request.error());
  request.value()["component"] = wish.component;
  auto answer = nodes.call(service_of_container(node, "load_component"), kLoadComponent, request.value(), kTransition);
  if (!answer) return err(answer.error());
  if (!answer.value()["success"].get<bool>()) return err(problem_of(answer.value()));
  json row = row_of(std::move(answer.value()["component"]));
  row["warnings"] = std::move(answer.value()["warnings"]);
  return row;
}

Result<json, Problem> unload_component(Nodes& nodes, const std::string& container, const std::string& name) {
  const auto found = nodes.container(container);
  if (!found) return err(found.error());
  const std::string& node = found.value().node;
  if (!found.value().is_nacelle) return unload_member(nodes, node, name);
  auto answer =
      nodes.call(service_of_container(node, "unload_component"), kUnloadComponent, {{"component", name}}, kTransition);
  if (!answer) return err(answer.error());
  if (!answer.value()["success"].get<bool>()) return err(problem_of(answer.value()));
  answer.value().erase("success");
  answer.value().erase("problem");
  return std::move(answer).value();
}

Result<json, Problem> lifecycle_state(Nodes& nodes, const std::string& name) {
  const auto found = nodes.locate(name);
  if (!found) return err(found.error());
  const std::string& node = found.value().node;
  const auto reply = [&](const json& id, const json& state) {
    return json{{"id", id}, {"node", node}, {"state", state["label"]}, {"state_id", state["id"]}};
  };
  if (found.value().container.empty()) {
    if (!nodes.prepare({{node + "/get_state", kGetState}}).front()) return err(without_lifecycle(node));
    const auto state = state_of(nodes, node);
    if (!state) return err(state.error());
    return reply(0, state.value());
  }
  const auto answer = components_of(nodes, found.value().container);
  if (!answer) return err(answer.error());
  for (const json& component : answer.value()["components"]) {
    if (text_of(component, "node") == node && component["managed"].get<bool>())
      return reply(component["id"], component["state"]);
  }
  return err(without_lifecycle(node));
}

Result<json, Problem> change_state(Nodes& nodes, const std::string& name, const std::string& transition) {
  const auto found = nodes.locate(name);
  if (!found) return err(found.error());
  const auto& [node, container] = found.value();
  if (!container.empty()) {
    const auto answer = nodes.call(service_of_container(container, "change_state"), kChangeState,
                                   {{"component", node}, {"transition", transition}}, kTransition);
    if (!answer) return err(answer.error());
    if (!answer.value()["success"].get<bool>()) return err(problem_of(answer.value()));
    return json{{"node", node}, {"state", answer.value()["state"]["label"]}};
  }
  if (!nodes.prepare({{node + "/change_state", kNodesChangeState}, {node + "/get_state", kGetState}}).front())
    return err(without_lifecycle(node));
  const auto answer =
      nodes.call(node + "/change_state", kNodesChangeState, {{"transition", {{"label", transition}}}}, kTransition);
  if (!answer) return err(answer.error());
  const auto state = state_of(nodes, node);
  if (!answer.value()["success"].get<bool>()) {
    return err(Problem{
        node, "could not " + transition,
        state ? "it is " + text_of(state.value(), "label") + " now" : "see `nacelle lifecycle get " + node + "`",
        LifecycleFault::TransitionFailed, transition});
  }
  return json{{"node", node}, {"state", state ? state.value()["label"] : json("")}};
}

}  // namespace nacelle::ask
