// SPDX-License-Identifier: Apache-2.0
// Lifecycle of nodes outside, by their services.
#include <utility>

#include "nacelle/control/client.hpp"
#include "nacelle/remote/remote_nodes.hpp"

namespace nacelle::remote {
namespace {

using control::reply_of;
using nlohmann::json;

/// A node that is there, and has no lifecycle; waits for one that may not be found yet.
std::optional<Problem> no_lifecycle(RemoteNetwork& network, const std::string& node) {
  if (network.find([&] { return offers(network, node, "get_state"); })) return std::nullopt;
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

}  // namespace

Result<RemoteState, Problem> state_of(RemoteNetwork& network, const std::string& node) {
  const auto answer = network.call(node + "/get_state", "lifecycle_msgs/srv/GetState", json::object(), kNodeAnswer);
  if (!answer) return err(answer.error());
  const json& state = answer.value()["current_state"];
  return RemoteState{state["id"].get<int>(), state["label"].get<std::string>()};
}

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

}  // namespace nacelle::remote
