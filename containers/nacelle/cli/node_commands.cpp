// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <map>
#include <memory>
#include <set>

#include "asking.hpp"
#include "commands.hpp"
#include "program.hpp"

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

/// Names with their types.
using Section = std::map<std::string, std::set<std::string>>;

constexpr const char* kSections[] = {"Subscribers",     "Publishers",     "Service Servers",
                                     "Service Clients", "Action Servers", "Action Clients"};

/// "/dock" and "nav2_msgs/action/Dock" of what an action is made of: "/dock/_action/<part>", "nav2_msgs/action/Dock_<Part>".
bool note_action(Section& section, const std::string& name, const std::string& type, const std::string& part,
                 const std::string& type_part) {
  const std::string ending = "/_action/" + part, type_ending = "_" + type_part;
  if (!name.ends_with(ending) || !type.ends_with(type_ending)) return false;
  section[name.substr(0, name.size() - ending.size())].insert(type.substr(0, type.size() - type_ending.size()));
  return true;
}

struct NodeView {
  std::map<std::string, Section> sections;
  std::set<std::string> standard;  ///< Names, shown or not.
  std::size_t left_out = 0;
};

NodeView view_of(const json& graph, const std::string& node, bool hidden, bool standard) {
  NodeView view;
  auto& sections = view.sections;
  const auto note = [&](const json& row, const char* title, const std::string& name, const std::string& type) {
    if (!hidden && is_hidden(name)) return;
    if (is_standard(row)) view.standard.insert(name);
    if (is_standard(row) && !standard) {
      ++view.left_out;
    } else {
      sections[title][name].insert(type);
    }
  };
  for (const auto& end : graph["endpoints"]) {
    if (text_of(end, "node") != node) continue;
    const std::string name = text_of(end, "topic"), type = text_of(end, "type");
    const bool publishes = end["publisher"].get<bool>();
    note(end, publishes ? "Publishers" : "Subscribers", name, type);
    if (!publishes) note_action(sections["Action Clients"], name, type, "feedback", "FeedbackMessage");
  }
  for (const auto& service : graph["services"]) {
    if (text_of(service, "node") != node) continue;
    const std::string name = text_of(service, "name"), type = text_of(service, "type");
    const bool serves = service["server"].get<bool>();
    note(service, serves ? "Service Servers" : "Service Clients", name, type);
    if (serves) note_action(sections["Action Servers"], name, type, "send_goal", "SendGoal");
  }
  return view;
}

int info(const NodeWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  auto node = node_of(graph.value(), wish.node);
  if (!node) return node.error();
  const std::string name = text_of(node.value(), "node");
  NodeView view = view_of(graph.value(), name, wish.all, wish.all || wish.as_json);
  auto& sections = view.sections;
  if (wish.as_json) {
    json answer{{"node", name}};
    for (const char* title : kSections) {
      std::string key = title;
      for (char& c : key) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      answer[key] = json::array();
      for (const auto& [entry, types] : sections[title]) {
        answer[key].push_back({{"name", entry}, {"types", types}});
        if (view.standard.contains(entry)) answer[key].back()["standard"] = true;
      }
    }
    std::printf("%s\n", answer.dump().c_str());
    return kDone;
  }
  std::printf("%s\n", name.c_str());
  for (const char* title : kSections) {
    std::printf("  %s:\n", title);
    for (const auto& [entry, types] : sections[title])
      std::printf("    %s: %s\n", entry.c_str(), join({types.begin(), types.end()}).c_str());
    std::printf("%s", sections[title].empty() ? "\n" : "");
  }
  std::fflush(stdout);
  tell_left_out(view.left_out);
  return kDone;
}

}  // namespace

void add_node_commands(Command& root) {
  Command& group = root.add("node", "the nodes of a running container");
  auto wish = std::make_shared<NodeWish>();

  Command& list_command = group.add("list", "the nodes");
  list_command.flag("-a,--all", wish->all, "those of tools and of parts of the container too");
  list_command.flag("-c,--count-nodes", wish->only_count, "only how many");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.runs([wish] { return list(*wish); });

  Command& info_command = group.add("info", "what a node publishes, reads, offers and calls, with the types");
  info_command.option("node", wish->node, "name or id").required().names_a(Names::Node);
  info_command.flag("-a,--all,--include-hidden", wish->all,
                    "hidden topics and services, and those that every node has, too");
  add_common_options(info_command, wish->whom, wish->as_json);
  info_command.runs([wish] { return info(*wish); });
}

}  // namespace nacelle::cli
