// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>

#include "ask/parameters.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/typed_value.hpp"
#include "graph_commands/commands.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/launch/parameter_file.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct ParamWish {
  Whom whom;
  std::string node, name, value, file;
  std::vector<std::string> names;
  bool as_json = false, with_types = false, hide_type = false;
};

/// Returns "node", its full name, and "parameters". Errors: the exit code.
Result<json, int> parameters_of(control::Client& client, const std::string& name) {
  ask::Nodes nodes{client};
  const auto node = nodes.find(name);
  if (!node) return err(complain(node.error()));
  auto rows = ask::list_parameters(nodes, node.value());
  if (!rows) return err(complain(rows.error()));
  return json{{"node", node.value()}, {"parameters", std::move(rows).value()}};
}

/// ros2's words: "boolean", "double array".
std::string type_words(const json& row) {
  const std::string type = text_of(row, "type");
  return type.starts_with("bool") ? "boolean" + type.substr(4) : type;
}

void print_list(const json& reply, bool with_types) {
  for (const auto& row : reply["parameters"]) {
    print_text("  %s", text_of(row, "name").c_str());
    print_text(with_types ? " (type: %s)\n" : "\n", type_words(row).c_str());
  }
}

int list(const ParamWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  if (!wish.node.empty()) {
    auto reply = parameters_of(client.value(), wish.node);
    if (!reply) return reply.error();
    if (wish.as_json) {
      std::printf("%s\n", reply.value()["parameters"].dump().c_str());
    } else {
      print_list(reply.value(), wish.with_types);
    }
    return kDone;
  }
  auto graph = ask::Nodes{client.value()}.graph();
  if (!graph) return complain(graph.error());
  const auto has_parameters = [](const json& row) { return row["id"] != 0 || row.value("parameters", false); };
  int result = kDone;
  json all = json::object();
  // A node that hangs, or runs in another process, does not hide the parameters of others.
  for (const auto& node : texts_of(graph.value()["nodes"], "node", has_parameters)) {
    auto reply = parameters_of(client.value(), node);
    if (!reply) {
      result = reply.error();
      continue;
    }
    all[node] = reply.value()["parameters"];
    if (wish.as_json) continue;
    print_text("%s:\n", node.c_str());
    print_list(reply.value(), wish.with_types);
  }
  if (wish.as_json) std::printf("%s\n", all.dump().c_str());
  return result;
}

/// Errors: the exit code; the nearest name has been printed.
Result<json, int> parameter_of(const json& reply, const std::string& name) {
  for (const auto& row : reply["parameters"]) {
    if (row["name"] == name) return json(row);
  }
  return err(complain_unknown(text_of(reply, "node") + ", parameter", name,
                              texts_of(reply["parameters"], "name", [](const json&) { return true; })));
}

/// As Python prints it.
std::string python_text(const json& value) {
  if (value.is_boolean()) return value.get<bool>() ? "True" : "False";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const auto& item : value)
    text += (text.empty() ? "" : ", ") + (item.is_string() ? "'" + item.get<std::string>() + "'" : python_text(item));
  return "[" + text + "]";
}

int get(const ParamWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  auto reply = parameters_of(client.value(), wish.node);
  if (!reply) return reply.error();
  auto row = parameter_of(reply.value(), wish.name);
  if (!row) return row.error();
  const json& value = row.value()["value"];
  if (wish.as_json) {
    std::printf(
        "%s\n",
        json{{"node", reply.value()["node"]}, {"name", wish.name}, {"type", row.value()["type"]}, {"value", value}}
            .dump()
            .c_str());
  } else if (value.is_null()) {
    std::printf("Parameter not set.\n");
  } else if (wish.hide_type) {
    print_text("%s\n", python_text(value).c_str());
  } else {
    std::string words = type_words(row.value());
    words[0] = static_cast<char>(words[0] - 'a' + 'A');
    if (const auto array = words.find(" array"); array != std::string::npos) words.resize(array);
    print_text("%s %s: %s\n", words.c_str(), value.is_array() ? "values are" : "value is", python_text(value).c_str());
  }
  return kDone;
}

/// Sets one parameter, or undeclares it, and prints how it went.
int change(const ParamWish& wish, const Parameter& parameter, const char* done) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  ask::Nodes nodes{client.value()};
  const auto node = nodes.find(wish.node);
  if (!node) return complain(node.error());
  if (auto set = ask::set_parameter(nodes, node.value(), parameter); !set) return complain(set.error());
  if (wish.as_json) {
    std::printf("%s\n", json{{"node", node.value()}, {"name", parameter.get_name()}}.dump().c_str());
  } else {
    print_text("%s\n", done);
  }
  return kDone;
}

int set(const ParamWish& wish) {
  if (auto value = check_value(wish.value); !value) return complain_of_usage(value.error());
  const auto parameter = ask::parameter_of_assignment(wish.name + ":=" + wish.value);
  if (!parameter) return complain(parameter.error());
  return change(wish, parameter.value(), "Set parameter successful");
}

int remove(const ParamWish& wish) {
  return change(wish, {wish.name, ParameterValue{}}, "Deleted parameter successfully");
}

int describe(const ParamWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  auto reply = parameters_of(client.value(), wish.node);
  if (!reply) return reply.error();
  json rows = json::array();
  for (const auto& name : wish.names) {
    auto row = parameter_of(reply.value(), name);
    if (!row) return row.error();
    rows.push_back(std::move(row).value());
  }
  if (wish.as_json) {
    std::printf("%s\n", rows.dump().c_str());
    return kDone;
  }
  for (const auto& row : rows) {
    print_text("Parameter name: %s\n  Type: %s\n", text_of(row, "name").c_str(), type_words(row).c_str());
    if (!text_of(row, "description").empty()) print_text("  Description: %s\n", text_of(row, "description").c_str());
    std::printf("  Constraints:\n");
    if (row["read_only"].get<bool>()) std::printf("    Read only: true\n");
    if (row.contains("from")) {
      print_text("    Min value: %s\n    Max value: %s\n", python_text(row["from"]).c_str(),
                 python_text(row["to"]).c_str());
      if (row["step"] != 0) print_text("    Step: %s\n", python_text(row["step"]).c_str());
    }
    if (!text_of(row, "constraints").empty())
      print_text("    Additional constraints: %s\n", text_of(row, "constraints").c_str());
  }
  return kDone;
}

int dump(const ParamWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  auto reply = parameters_of(client.value(), wish.node);
  if (!reply) return reply.error();
  json values = json::object();
  std::string text = text_of(reply.value(), "node") + ":\n  ros__parameters:\n";
  bool any = false;
  for (const auto& row : reply.value()["parameters"]) {
    if (row["value"].is_null()) continue;  // a file cannot say "not set"
    any = true;
    values[text_of(row, "name")] = row["value"];
    text += "    " + text_of(row, "name") + ": " + text_of(row, "text") + "\n";
  }
  if (!any) text += "    {}\n";
  if (wish.as_json) {
    std::printf("%s\n", json{{text_of(reply.value(), "node"), {{"ros__parameters", values}}}}.dump().c_str());
  } else {
    print_text("%s", text.c_str());
  }
  return kDone;
}

/// What a parameter file gives to a node. Errors: the exit code.
Result<std::vector<launch::Parameter>, int> read_file(const std::string& path, const std::string& node) {
  const auto text = read_regular_file(std::filesystem::absolute(path).string());
  if (!text) return err(complain(text.error()));
  auto parsed = launch::parse_parameter_file(text.value(), path);
  if (!parsed) {
    for (const auto& problem : parsed.error()) complain(problem);
    return err(kFailed);
  }
  auto found = parsed.value().parameters_for(node);
  if (!found.empty()) return found;
  std::vector<std::string> patterns;
  for (const auto& section : parsed.value().sections()) patterns.push_back(section.pattern);
  return err(complain({path, "has no parameters for " + node,
                       patterns.empty() ? "it names no node" : "it has them for " + join(patterns)}));
}

int load(const ParamWish& wish) {
  auto client = connect(wish.whom);
  if (!client) return client.error();
  auto there = parameters_of(client.value(), wish.node);
  if (!there) return there.error();
  auto wanted = read_file(wish.file, text_of(there.value(), "node"));
  if (!wanted) return wanted.error();
  // What is read-only and as the file has it is no failure: a dump of the same node loads.
  std::map<std::string, std::string> fixed;
  std::vector<std::string> names;
  for (const auto& row : there.value()["parameters"]) {
    names.push_back(text_of(row, "name"));
    if (row["read_only"].get<bool>()) fixed[text_of(row, "name")] = text_of(row, "text");
  }
  std::vector<Parameter> changes;
  for (const auto& parameter : wanted.value()) {
    if (const auto same = fixed.find(parameter.name);
        same != fixed.end() && same->second == launch::to_text(parameter.value))
      continue;
    changes.emplace_back(parameter.name, parameter.value);
  }
  ask::Nodes nodes{client.value()};
  const auto outcomes = ask::set_parameters(nodes, text_of(there.value(), "node"), changes);
  if (!outcomes) return complain(outcomes.error());
  bool all_set = true;
  json rows = json::array();
  for (auto [name, refusal] : outcomes.value()) {
    if (!refusal.empty() && std::ranges::find(names, name) == names.end())
      refusal = "there is no such parameter; " + suggestion(name, names);
    rows.push_back({{"name", name}, {"refusal", refusal}});
    all_set = all_set && refusal.empty();
    if (!refusal.empty()) {
      complain({"Set parameter " + name + " failed", refusal, ""});
    } else if (!wish.as_json) {
      print_text("Set parameter %s successful\n", name.c_str());
    }
  }
  if (wish.as_json) std::printf("%s\n", rows.dump().c_str());
  return all_set ? kDone : kFailed;
}

}  // namespace

void add_param_commands(Command& root) {
  Command& group = root.add("param", "show and change the parameters of a node");
  auto wish = std::make_shared<ParamWish>();
  const auto add = [&](const char* name, const char* what, bool needs_node = true) -> Command& {
    Command& command = group.add(name, what);
    Option& node = command.option("node", wish->node, needs_node ? "name or id" : "name or id; default: every node");
    node.names_a(Names::Node);
    if (needs_node) node.required();
    return command;
  };
  const auto finish = [&](Command& command, int (*what)(const ParamWish&)) {
    add_common_options(command, wish->whom, wish->as_json);
    command.runs([wish, what] { return what(*wish); });
  };

  Command& list_command = add("list", "list the parameters", false);
  list_command.flag("--param-type", wish->with_types, "their types too");
  finish(list_command, list);

  Command& get_command = add("get", "show the value of a parameter");
  get_command.option("name", wish->name, "").required().names_a(Names::Parameter);
  get_command.flag("--hide-type", wish->hide_type, "the value alone");
  finish(get_command, get);

  Command& set_command = add("set", "set a parameter, if the node allows it; the value survives a restart of the node");
  set_command.option("name", wish->name, "").required().names_a(Names::Parameter);
  set_command.option("value", wish->value, "in YAML: 5, 0.5, true, text, [1, 2]").required();
  finish(set_command, set);

  Command& dump_command = add("dump", "print the parameters as a parameter file for `param load` and launch files");
  finish(dump_command, dump);

  Command& load_command = add("load", "set a node's parameters from a parameter file");
  load_command.option("file", wish->file, "a ROS 2 parameter file").required().names_a(Names::File);
  finish(load_command, load);

  Command& describe_command = add("describe", "describe parameters: type, meaning and constraints");
  describe_command.option("names", wish->names, "").required().names_a(Names::Parameter);
  finish(describe_command, describe);

  Command& delete_command = add("delete", "undeclare a parameter that was declared with dynamic typing");
  delete_command.option("name", wish->name, "").required().names_a(Names::Parameter);
  finish(delete_command, remove);
}

}  // namespace nacelle::cli
