// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "graph_commands/node_view.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct NodeWish {
  Whom whom;
  std::string node;
  bool as_json = false, all = false, only_count = false;
};

int list(const NodeWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const auto shown = [&](const json& row) { return wish.all || !row["hidden"].get<bool>(); };
  print_names(texts_of(graph.value()["nodes"], "node", shown), wish.only_count, wish.as_json);
  return kDone;
}

int info(const NodeWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  auto node = node_of(graph.value(), wish.node);
  if (!node) return node.error();
  const std::string name = text_of(node.value(), "node");
  const NodeView view = view_of(graph.value(), name, wish.all, wish.all || wish.as_json);
  if (wish.as_json) {
    json answer{{"node", name}};
    add_to_json(answer, view);
    std::printf("%s\n", answer.dump().c_str());
    return kDone;
  }
  print_text("%s\n", name.c_str());
  print(view);
  std::fflush(stdout);
  tell_left_out(view.left_out);
  return kDone;
}

}  // namespace

void add_node_commands(Command& root) {
  Command& group = root.add("node", "list the nodes and show their interfaces");
  auto wish = std::make_shared<NodeWish>();

  Command& list_command = group.add("list", "list the nodes");
  list_command.flag("-a,--all", wish->all, "include nodes of tools and of the container itself");
  list_command.flag("-c,--count-nodes", wish->only_count, "only how many");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.runs([wish] { return list(*wish); });

  Command& info_command = group.add("info", "show a node's topics, services and actions with their types");
  info_command.option("node", wish->node, "name or id").required().names_a(Names::Node);
  info_command.flag("-a,--all,--include-hidden", wish->all,
                    "include hidden topics and services, and those that every node has");
  add_common_options(info_command, wish->whom, wish->as_json);
  info_command.runs([wish] { return info(*wish); });
}

}  // namespace nacelle::cli
