// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>

#include "ask/composition.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/host/lifecycle_graph.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct LifecycleWish {
  Whom whom;
  std::string node, transition;
  bool as_json = false, all = false, only_count = false;
};

int list_transitions(const LifecycleWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  auto reply = ask::lifecycle_state(nodes, wish.node);
  if (!reply) return complain(reply.error());
  const std::string state = text_of(reply.value(), "state");
  json rows = json::array();
  for (const LifecycleEdge& edge : kLifecycleGraph) {
    const char* const start = nacelle::to_text(edge.start);
    if (wish.all || state == start)
      rows.push_back({{"label", edge.label}, {"id", edge.id}, {"start", start}, {"goal", nacelle::to_text(edge.goal)}});
  }
  if (wish.as_json) {
    std::printf("%s\n", json{{"node", reply.value()["node"]}, {"state", state}, {"transitions", rows}}.dump().c_str());
    return kDone;
  }
  if (rows.empty()) {
    print_text("%s is %s: no transition leads on\n", text_of(reply.value(), "node").c_str(), state.c_str());
    if (state == "finalized")
      print_text("Unload it, and load it again: nacelle component unload %s\n", wish.node.c_str());
  }
  for (const auto& row : rows) {
    print_text("- %s [%d]\n\tStart: %s\n\tGoal: %s\n", text_of(row, "label").c_str(), row["id"].get<int>(),
               text_of(row, "start").c_str(), text_of(row, "goal").c_str());
  }
  return kDone;
}

int list_nodes(const LifecycleWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  json managed = json::array();
  for (const auto& row : graph.value()["nodes"]) {
    if (row["managed"].get<bool>())
      managed.push_back({{"node", row["node"]}, {"id", row["id"]}, {"state", row["state"]}});
  }
  std::sort(managed.begin(), managed.end(),
            [](const json& a, const json& b) { return text_of(a, "node") < text_of(b, "node"); });
  if (wish.as_json && !wish.only_count) {
    std::printf("%s\n", managed.dump().c_str());
  } else {
    print_names(texts_of(managed, "node", [](const json&) { return true; }), wish.only_count, wish.as_json);
  }
  return kDone;
}

int get_state(const LifecycleWish& wish) {
  return ask_nodes(
      wish.whom, wish.as_json, [&](ask::Nodes& nodes) { return ask::lifecycle_state(nodes, wish.node); },
      [](const json& reply) {
        print_text("%s [%d]\n", text_of(reply, "state").c_str(), reply["state_id"].get<int>());
      });
}

int set_state(const LifecycleWish& wish) {
  return ask_nodes(
      wish.whom, wish.as_json, [&](ask::Nodes& nodes) { return ask::change_state(nodes, wish.node, wish.transition); },
      [](const json&) { std::printf("Transitioning successful\n"); });
}

}  // namespace

void add_lifecycle_commands(Command& root) {
  Command& group = root.add("lifecycle", "show and change the state of a component");
  auto wish = std::make_shared<LifecycleWish>();

  Command& get_command = group.add("get", "show the state of a component");
  get_command.option("node", wish->node, "name or id").required().names_a(Names::Node);
  add_common_options(get_command, wish->whom, wish->as_json);
  get_command.runs([wish] { return get_state(*wish); });

  Command& list_command = group.add("list", "list the transitions that are available to a component");
  list_command.option("node", wish->node, "name or id").required().names_a(Names::Node);
  list_command.flag("-a,--all", wish->all, "list every transition of the state machine");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.runs([wish] { return list_transitions(*wish); });

  Command& nodes_command = group.add("nodes", "list the lifecycle components");
  nodes_command.flag("-c,--count-nodes", wish->only_count, "only how many");
  add_common_options(nodes_command, wish->whom, wish->as_json);
  nodes_command.runs([wish] { return list_nodes(*wish); });

  Command& set_command = group.add("set", "trigger a transition of a component");
  set_command.option("node", wish->node, "name or id").required().names_a(Names::Node);
  set_command.option("transition", wish->transition, "configure, activate, deactivate, cleanup or shutdown")
      .required()
      .one_of({"configure", "activate", "deactivate", "cleanup", "shutdown"});
  add_common_options(set_command, wish->whom, wish->as_json);
  set_command.runs([wish] { return set_state(*wish); });
}

}  // namespace nacelle::cli
