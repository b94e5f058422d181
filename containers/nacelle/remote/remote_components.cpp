// SPDX-License-Identifier: Apache-2.0
// Lifecycle and composition of nodes outside, by their services.
#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "nacelle/base/names.hpp"
#include "nacelle/control/client.hpp"
#include "nacelle/node/lifecycle_graph.hpp"
#include "nacelle/remote/remote_nodes.hpp"
#include "nacelle/session/verbs.hpp"

namespace nacelle::remote {
namespace {

using control::reply_of;
using nlohmann::json;

constexpr Duration kNodeAnswer = 3s;
// A component may take its time to find its device.
constexpr Duration kTransition = 80s;
constexpr std::string_view kListNodes = "/_container/list_nodes";

struct State {
  int id = 0;
  std::string label;
};

Result<State, Problem> state_of(RemoteNetwork& network, const std::string& node) {
  const auto answer = network.call(node + "/get_state", "lifecycle_msgs/srv/GetState", json::object(), kNodeAnswer);
  if (!answer) return err(answer.error());
  const json& state = answer.value()["current_state"];
  return State{state["id"].get<int>(), state["label"].get<std::string>()};
}

/// A node that is there, and has no lifecycle; waits for one that may not be found yet.
std::optional<Problem> no_lifecycle(RemoteNetwork& network, const std::string& node) {
  if (network.wait(network.patience(), [&] { return offers(network, node, "get_state"); })) return std::nullopt;
  return Problem{node, "is a plain node without a lifecycle", "see `nacelle lifecycle nodes --remote`"};
}

json set_state(RemoteNetwork& network, const std::string& node, const std::string& transition) {
  const auto answer = network.call(node + "/change_state", "lifecycle_msgs/srv/ChangeState",
                                   {{"transition", {{"label", transition}}}}, kTransition);
  if (!answer) return reply_of(answer.error());
  const auto state = state_of(network, node);
  if (!answer.value()["success"].get<bool>()) {
    return reply_of(
        {node, "could not " + transition,
         state ? "it is " + state.value().label + " now" : "see `nacelle lifecycle get --remote " + node + "`"});
  }
  return {{"ok", true}, {"node", node}, {"state", state ? state.value().label : ""}};
}

// --- composition -----------------------------------------------------------------------------------------------------

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
  static_cast<void>(network.wait(network.found_by(), [&] { return containers_of(network).contains(wanted); }));
  const auto all = containers_of(network);
  if (all.contains(wanted)) return wanted;
  if (name.empty() && all.size() == 1) return *all.begin();
  const std::vector<std::string> names(all.begin(), all.end());
  if (names.empty())
    return err(Problem{"containers", "none was found in " + network.where(), "see `nacelle node list --remote`"});
  if (name.empty()) return err(Problem{"containers", "there are " + join(names), "give --container one of them"});
  return err(Problem{"container '" + name + "'", "is not there in " + network.where(), suggestion(wanted, names)});
}

Result<json, Problem> listed(RemoteNetwork& network, const std::string& container) {
  return network.call(container + std::string{kListNodes}, "composition_interfaces/srv/ListNodes", json::object(),
                      kNodeAnswer);
}

json list_components(RemoteNetwork& network, const std::string& container) {
  const auto answer = listed(network, container);
  if (!answer) return reply_of(answer.error());
  const json& names = answer.value()["full_node_names"];
  const json& ids = answer.value()["unique_ids"];
  for (const auto& name : names) {
    if (offers(network, name, "get_state"))
      static_cast<void>(network.prepare(name.get<std::string>() + "/get_state", "lifecycle_msgs/srv/GetState"));
  }
  json rows = json::array();
  for (std::size_t i = 0; i < std::min(names.size(), ids.size()); ++i) {
    const std::string node = names[i].get<std::string>();
    const bool managed = offers(network, node, "get_state");
    const auto state = managed ? state_of(network, node) : err(Problem{});
    rows.push_back({{"id", ids[i]},
                    {"node", node},
                    {"plugin", ""},
                    {"library", ""},
                    {"managed", managed},
                    {"state", state ? state.value().label : ""}});
  }
  return {{"ok", true}, {"container", container.substr(1)}, {"components", rows}, {"kept_images", json::array()}};
}

json load(RemoteNetwork& network, const std::string& container, const json& request) {
  auto wanted = session::plugin_request_of(request, "/");
  if (!wanted) return reply_of(wanted.error());
  const runtime::LoadRequest& load = wanted.value();
  json parameters = json::array(), remaps = json::array();
  for (const auto& [name, value] : load.parameters)
    parameters.push_back({{"name", name}, {"value", parameter_message(value)}});
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
  const auto answer = listed(network, container);
  if (!answer) return reply_of(answer.error());
  const json& names = answer.value()["full_node_names"];
  const json& ids = answer.value()["unique_ids"];
  std::vector<std::string> all;
  for (std::size_t i = 0; i < std::min(names.size(), ids.size()); ++i) {
    const std::string node = names[i].get<std::string>();
    all.push_back(node);
    if (node != name && node != "/" + name && ids[i].dump() != name) continue;
    const auto done = network.call(container + "/_container/unload_node", "composition_interfaces/srv/UnloadNode",
                                   {{"unique_id", ids[i]}}, kTransition);
    if (!done) return reply_of(done.error());
    if (!done.value()["success"].get<bool>())
      return reply_of({container, done.value()["error_message"].get<std::string>(), ""});
    return {{"ok", true}, {"id", ids[i]}, {"node", node}, {"library", ""}, {"image_closed", true}, {"held_by", ""}};
  }
  return reply_of(
      {"component '" + name + "'", "is not in " + container, all.empty() ? "it holds none" : suggestion(name, all)});
}

}  // namespace

json reply_to_lifecycle_verb(RemoteNetwork& network, const std::string& verb, const json& request) {
  auto found = node_named(network, request.value("name", ""));
  if (!found) return reply_of(found.error());
  const std::string& node = found.value();
  if (const auto problem = no_lifecycle(network, node)) return reply_of(*problem);
  if (verb == "lifecycle.set") {
    static_cast<void>(network.prepare(node + "/get_state", "lifecycle_msgs/srv/GetState"));
    return set_state(network, node, request.value("transition", ""));
  }
  const auto state = state_of(network, node);
  if (!state) return reply_of(state.error());
  return {{"ok", true}, {"id", 0}, {"node", node}, {"state", state.value().label}, {"state_id", state.value().id}};
}

json reply_to_component_verb(RemoteNetwork& network, const std::string& verb, const json& request) {
  if (verb == "component.load") {
    return reply_of({"component " + request.value("name", ""),
                     "a container outside does not tell what its launch file names",
                     "load a plugin: pkg::Class --name N"});
  }
  auto container = container_named(network, request.value("container", ""));
  if (!container) return reply_of(container.error());
  if (verb == "component.list") return list_components(network, container.value());
  if (verb == "component.load_plugin") return load(network, container.value(), request);
  if (verb == "component.unload") return unload(network, container.value(), request.value("name", ""));
  return reply_of({"request '" + verb + "'", "cannot be asked of a container outside", "ask it without --remote"});
}

}  // namespace nacelle::remote
