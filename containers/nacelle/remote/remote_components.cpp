// SPDX-License-Identifier: Apache-2.0
// Composition of nodes outside, by the services of their containers.
#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "nacelle/ask/parameters.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/control/client.hpp"
#include "nacelle/remote/graph_rows.hpp"
#include "nacelle/remote/remote_nodes.hpp"
#include "nacelle/session/verbs.hpp"

namespace nacelle::remote {
namespace {

using control::reply_of;
using nlohmann::json;

constexpr std::string_view kListNodes = "/_container/list_nodes";

/// The nodes that are containers.
std::set<std::string> containers_of(const RemoteNetwork& network) {
  std::set<std::string> names;
  const auto all = network.look([](const auto& graph) { return graph.services(); });
  for (const auto& [name, types] : all) {
    if (name.ends_with(kListNodes) && types.contains("composition_interfaces/srv/ListNodes"))
      names.insert(name.substr(0, name.size() - kListNodes.size()));
  }
  return names;
}

Result<std::string, Problem> container_named(RemoteNetwork& network, const std::string& name) {
  const std::string wanted = name.empty() || name.starts_with('/') ? name : "/" + name;
  // One that is named is enough; to know that there is only one takes the whole time.
  if (wanted.empty()) {
    network.find_all();
  } else {
    static_cast<void>(network.find([&] { return containers_of(network).contains(wanted); }));
  }
  const auto all = containers_of(network);
  if (all.contains(wanted)) return wanted;
  if (name.empty() && all.size() == 1) return *all.begin();
  const std::vector<std::string> names(all.begin(), all.end());
  if (names.empty())
    return err(Problem{"containers", "none was found in " + network.where(), "see `nacelle node list --remote`"});
  if (name.empty()) return err(Problem{"containers", "there are " + join(names), "give --container one of them"});
  return err(Problem{"container '" + name + "'", "is not there in " + network.where(), suggestion(wanted, names)});
}

struct Component {
  json id;
  std::string node;
};

Result<std::vector<Component>, Problem> components_of(RemoteNetwork& network, const std::string& container) {
  const auto answer = network.call(container + std::string{kListNodes}, "composition_interfaces/srv/ListNodes",
                                   json::object(), kNodeAnswer);
  if (!answer) return err(answer.error());
  const json& names = answer.value()["full_node_names"];
  const json& ids = answer.value()["unique_ids"];
  std::vector<Component> all;
  for (std::size_t i = 0; i < std::min(names.size(), ids.size()); ++i)
    all.push_back({ids[i], names[i].get<std::string>()});
  return all;
}

/// By its full name, its id, or its name without the namespace if there is one such.
Result<Component, Problem> component_named(RemoteNetwork& network, const std::string& container,
                                           const std::string& name) {
  const auto all = components_of(network, container);
  if (!all) return err(all.error());
  std::vector<std::string> names, hits;
  const Component* hit = nullptr;
  for (const Component& one : all.value()) {
    if (one.node == name || one.node == "/" + name || one.id.dump() == name) return one;
    names.push_back(one.node);
    if (name.starts_with('/') || !one.node.ends_with("/" + name)) continue;
    hits.push_back(one.node);
    hit = &one;
  }
  if (hits.size() == 1) return *hit;
  const std::string what = "component '" + name + "'";
  if (!hits.empty()) return err(Problem{what, "could be any of " + join(hits), "give the full name or the id"});
  return err(Problem{what, "is not in " + container, names.empty() ? "it holds none" : suggestion(name, names)});
}

json list_components(RemoteNetwork& network, const std::string& container) {
  const auto all = components_of(network, container);
  if (!all) return reply_of(all.error());
  for (const Component& one : all.value()) {
    if (offers(network, one.node, "get_state"))
      static_cast<void>(network.prepare(one.node + "/get_state", "lifecycle_msgs/srv/GetState"));
  }
  json rows = json::array();
  for (const Component& one : all.value()) {
    const bool managed = offers(network, one.node, "get_state");
    const auto state = managed ? state_of(network, one.node) : err(Problem{});
    rows.push_back({{"id", one.id},
                    {"node", one.node},
                    {"plugin", ""},
                    {"library", ""},
                    {"managed", managed},
                    {"state", state ? state.value().label : ""}});
  }
  return {{"ok", true}, {"container", container.substr(1)}, {"components", rows}, {"kept_images", json::array()}};
}

/// What its participant announces of itself; what it does not is left out.
void add_process(json& reply, const RemoteNetwork& network) {
  for (const auto& node : network.look([](const auto& graph) { return graph.nodes(); })) {
    if (full_name(node.node_namespace, node.name) != reply["node"].get_ref<const std::string&>()) continue;
    reply["namespace"] = node.node_namespace;
    for (const auto& [key, text] : {std::pair{"host", node.host}, {"pid", node.pid}, {"enclave", node.enclave}}) {
      if (!text.empty()) reply[key] = text;
    }
    return;
  }
}

json info(RemoteNetwork& network, const std::string& container, const std::string& name) {
  const auto found = component_named(network, container, name);
  if (!found) return reply_of(found.error());
  const std::string& node = found.value().node;
  // What is not known by then, it does not have.
  network.find_all();
  const bool managed = offers(network, node, "get_state");
  json reply{
      {"ok", true}, {"container", container.substr(1)}, {"id", found.value().id}, {"node", node}, {"managed", managed},
      {"state", ""}};
  add_process(reply, network);
  if (!managed) return reply;
  if (const auto state = state_of(network, node); state) {
    reply["state"] = state.value().label;
    reply["state_id"] = state.value().id;
  } else {
    reply["warnings"] = {state.error().text()};
  }
  return reply;
}

json load(RemoteNetwork& network, const std::string& container, const json& request) {
  auto wanted = session::plugin_request_of(request, "/");
  if (!wanted) return reply_of(wanted.error());
  const runtime::LoadRequest& load = wanted.value();
  json parameters = json::array(), remaps = json::array();
  for (const auto& [name, value] : load.parameters)
    parameters.push_back({{"name", name}, {"value", ask::message_of(value)}});
  for (const auto& rule : load.remaps) remaps.push_back(to_text(rule));
  // A class is taken to be in the package of its first namespace; a Nacelle container does not ask for it.
  const std::string package = load.plugin.substr(0, load.plugin.find("::"));
  const auto answer = network.call(container + "/_container/load_node", "composition_interfaces/srv/LoadNode",
                                   {{"package_name", package},
                                    {"plugin_name", load.plugin},
                                    {"node_name", load.name},
                                    {"node_namespace", request.value("namespace", "")},
                                    {"parameters", parameters},
                                    {"remap_rules", remaps}},
                                   kTransition);
  if (!answer) return reply_of(answer.error());
  if (!answer.value()["success"].get<bool>())
    return reply_of({container, answer.value()["error_message"].get<std::string>(), ""});
  return {{"ok", true},
          {"id", answer.value()["unique_id"]},
          {"node", answer.value()["full_node_name"]},
          {"plugin", load.plugin},
          {"managed", false},
          {"state", ""},
          {"warnings", json::array()}};
}

json unload(RemoteNetwork& network, const std::string& container, const std::string& name) {
  const auto found = component_named(network, container, name);
  if (!found) return reply_of(found.error());
  const auto& [id, node] = found.value();
  const auto done = network.call(container + "/_container/unload_node", "composition_interfaces/srv/UnloadNode",
                                 {{"unique_id", id}}, kTransition);
  if (!done) return reply_of(done.error());
  if (!done.value()["success"].get<bool>())
    return reply_of({container, done.value()["error_message"].get<std::string>(), ""});
  return {{"ok", true}, {"id", id}, {"node", node}, {"library", ""}, {"image_closed", true}, {"held_by", ""}};
}

}  // namespace

json reply_to_component_verb(RemoteNetwork& network, const std::string& verb, const json& request) {
  if (verb == "component.load") {
    return reply_of({"component " + request.value("name", ""),
                     "a container outside does not tell what its launch file names",
                     "load a plugin: pkg::Class --name N"});
  }
  auto container = container_named(network, request.value("container", ""));
  if (!container) return reply_of(container.error());
  if (verb == "component.list") return list_components(network, container.value());
  if (verb == "component.info") return info(network, container.value(), request.value("name", ""));
  if (verb == "component.load_plugin") return load(network, container.value(), request);
  if (verb == "component.unload") return unload(network, container.value(), request.value("name", ""));
  return reply_of({"request '" + verb + "'", "cannot be asked of a container outside", "ask it without --remote"});
}

}  // namespace nacelle::remote
