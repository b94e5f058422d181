// SPDX-License-Identifier: Apache-2.0
#include "graph_commands/action_commands.hpp"

#include <cstdio>
#include <memory>

#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/host/action_names.hpp"
#include "nacelle/msgs/type_library.hpp"

namespace nacelle::cli {

using nlohmann::json;

std::map<std::string, ActionEnds> actions_of(const json& graph) {
  std::map<std::string, ActionEnds> actions;
  for (const auto& end : graph["endpoints"]) {
    const auto action = action::action_of_topic(text_of(end, "topic"), text_of(end, "type"));
    const std::string node = text_of(end, "node");
    if (!action || node.empty()) continue;
    ActionEnds& ends = actions[action->name];
    ends.types.insert(action->type);
    (end["publisher"].get<bool>() ? ends.servers : ends.clients)[node] = action->type;
  }
  return actions;
}

std::vector<std::string> names_of(const std::map<std::string, ActionEnds>& actions) {
  std::vector<std::string> names;
  names.reserve(actions.size());
  for (const auto& [name, ends] : actions) names.push_back(name);
  return names;
}

namespace {

struct ActionWish {
  Whom whom;
  std::string name;
  bool as_json = false, with_types = false, only_count = false;
};

std::string types_text(const std::set<std::string>& types) { return join({types.begin(), types.end()}); }

int list(const ActionWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const auto actions = actions_of(graph.value());
  if (wish.only_count || (!wish.as_json && !wish.with_types)) {
    print_names(names_of(actions), wish.only_count, wish.as_json);
    return kDone;
  }
  json rows = json::array();
  for (const auto& [name, ends] : actions) {
    rows.push_back({{"name", name}, {"types", ends.types}});
    if (!wish.as_json) print_text("%s [%s]\n", name.c_str(), types_text(ends.types).c_str());
  }
  if (wish.as_json) std::printf("%s\n", rows.dump().c_str());
  return kDone;
}

/// Returns the named action. Errors: the exit code; the nearest name has been printed to stderr.
Result<ActionEnds, int> ends_of(const ActionWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return err(graph.error());
  const auto actions = actions_of(graph.value());
  const auto found = actions.find(absolute(wish.name));
  if (found == actions.end()) return err(complain_unknown("action", absolute(wish.name), names_of(actions)));
  return found->second;
}

json rows_of(const std::map<std::string, std::string>& nodes) {
  json rows = json::array();
  for (const auto& [node, type] : nodes) rows.push_back({{"node", node}, {"type", type}});
  return rows;
}

void print_ends(const char* title, const std::map<std::string, std::string>& nodes, const ActionWish& wish) {
  print_text("Action %s: %zu\n", title, nodes.size());
  if (wish.only_count) return;
  for (const auto& [node, type] : nodes)
    print_text(wish.with_types ? "    %s [%s]\n" : "    %s\n", node.c_str(), type.c_str());
}

int info(const ActionWish& wish) {
  auto ends = ends_of(wish);
  if (!ends) return ends.error();
  if (wish.as_json) {
    const json answer{{"action", absolute(wish.name)},
                      {"types", ends.value().types},
                      {"clients", rows_of(ends.value().clients)},
                      {"servers", rows_of(ends.value().servers)}};
    std::printf("%s\n", answer.dump().c_str());
    return kDone;
  }
  print_text("Action: %s\n", absolute(wish.name).c_str());
  print_ends("clients", ends.value().clients, wish);
  print_ends("servers", ends.value().servers, wish);
  return kDone;
}

int show_type(const ActionWish& wish) {
  auto ends = ends_of(wish);
  if (!ends) return ends.error();
  print_names({ends.value().types.begin(), ends.value().types.end()}, false, wish.as_json);
  return kDone;
}

int find(const ActionWish& wish) {
  auto graph = graph_of(wish.whom);
  if (!graph) return graph.error();
  const std::string type = full_type_name(wish.name, "action");
  std::vector<std::string> names;
  std::set<std::string> types;
  for (const auto& [name, ends] : actions_of(graph.value())) {
    types.insert(ends.types.begin(), ends.types.end());
    if (ends.types.count(type) != 0) names.push_back(name);
  }
  // A type that exists without a server is an empty answer; one that does not exist is probably misspelt.
  msgs::TypeLibrary library{program_places().message_folders};
  if (auto known = library.find(type); names.empty() && !known) return complain(known.error());
  print_names(names, wish.only_count, wish.as_json);
  return kDone;
}

}  // namespace

void add_action_commands(Command& root) {
  Command& group = root.add("action", "list actions and their types, and send goals");
  auto wish = std::make_shared<ActionWish>();
  auto goal = std::make_shared<GoalWish>();

  Command& list_command = group.add("list", "list the actions");
  list_command.flag("-t,--show-types", wish->with_types, "the types too");
  list_command.flag("-c,--count-actions", wish->only_count, "only how many");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.runs([wish] { return list(*wish); });

  Command& info_command = group.add("info", "show the servers and clients of an action");
  info_command.option("action", wish->name, "e.g. /fibonacci").required().names_a(Names::Action);
  info_command.flag("-t,--show-types", wish->with_types, "the types too");
  info_command.flag("-c,--count", wish->only_count, "only how many");
  add_common_options(info_command, wish->whom, wish->as_json);
  info_command.runs([wish] { return info(*wish); });

  Command& type_command = group.add("type", "show the type of an action");
  type_command.option("action", wish->name, "e.g. /fibonacci").required().names_a(Names::Action);
  add_common_options(type_command, wish->whom, wish->as_json);
  type_command.runs([wish] { return show_type(*wish); });

  Command& find_command = group.add("find", "list the actions of a type");
  find_command.option("type", wish->name, "e.g. example_interfaces/action/Fibonacci")
      .required()
      .names_a(Names::ActionType);
  find_command.flag("-c,--count,--count-actions", wish->only_count, "only how many");
  add_common_options(find_command, wish->whom, wish->as_json);
  find_command.runs([wish] { return find(*wish); });

  Command& send = group.add("send_goal", "send a goal and wait for its result; Ctrl-C cancels it");
  send.option("action", goal->action, "e.g. /fibonacci").required().names_a(Names::Action);
  send.option("type", goal->type, "e.g. example_interfaces/action/Fibonacci").required().names_a(Names::ActionType);
  send.option("goal", goal->goal, "YAML, e.g. \"{order: 5}\"; missing fields take their defaults");
  send.flag("--stdin", goal->from_stdin, "read the goal from standard input");
  send.flag("-f,--feedback", goal->feedback, "show feedback as it arrives");
  send.option("--timeout", goal->timeout_s, "cancel the goal after this many seconds; 0: never")
      .value("SECONDS")
      .within(0, 86400);
  add_common_options(send, goal->whom, goal->as_json);
  send.note("Exit code 0 only if the goal succeeded.");
  send.runs([goal] { return send_goal(*goal); });
}

}  // namespace nacelle::cli
