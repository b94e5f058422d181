// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>

#include "ask/composition.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/typed_value.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "robot_commands/commands.hpp"
#include "robot_commands/component_info.hpp"
#include "robot_commands/component_reference.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct ComponentWish {
  Whom whom;
  std::string name, new_name, name_space, params_file;
  std::vector<std::string> parameters, remaps;
  bool as_json = false, details = false, doc = false;
};

int list(const ComponentWish& wish) {
  const auto show = [&](const json& reply) {
    print_text("/%s\n", text_of(reply, "container").c_str());
    for (const auto& row : reply["components"]) {
      print_text("  %d  %s", row["id"].get<int>(), text_of(row, "node").c_str());
      print_text("  %s", row["managed"].get<bool>() ? text_of(row, "state").c_str() : "node");
      if (wish.details) print_text("  %s", text_of(row, "plugin").c_str());
      if (row.contains("fault")) print_text("  faulted: %s", fault_text(row["fault"]).c_str());
      for (const auto& fault : row.value("open_faults", json::array()))
        print_text("  open fault: %s", fault_text(fault).c_str());
      std::printf("\n");
      for (const auto& node : row.value("other_nodes", json::array()))
        print_text("     and its node %s\n", node.get<std::string>().c_str());
    }
    for (const auto& image : reply["kept_images"]) {
      print_text("  image kept: %s of %s, held by %s\n", text_of(image, "library").c_str(),
                 text_of(image, "node").c_str(), text_of(image, "held_by").c_str());
    }
  };
  return ask_nodes(
      wish.whom, wish.as_json, [&](ask::Nodes& nodes) { return ask::list_components(nodes, wish.whom.container); },
      show);
}

int load(const ComponentWish& wish) {
  // A class name has '::'; a name of the launch file has not.
  const bool is_plugin = wish.name.find("::") != std::string::npos;
  const bool has_options = !wish.new_name.empty() || !wish.name_space.empty() || !wish.parameters.empty() ||
                           !wish.remaps.empty() || !wish.params_file.empty();
  if (!is_plugin && has_options) {
    return complain_of_usage({"component load " + wish.name, "it comes with the launch file's parameters and remaps",
                              "options belong to a plugin: pkg::Class --name N"});
  }
  ask::LoadWish wanted{wish.name, wish.new_name, wish.name_space, wish.parameters, wish.remaps, {}, {}};
  if (!wish.params_file.empty()) {
    wanted.parameters_file = std::filesystem::absolute(wish.params_file).string();
    auto text = read_regular_file(wanted.parameters_file, ask::kMostParametersText);
    if (!text) return complain({wanted.parameters_file, text.error().what, "give a parameter file in ROS 2's form"});
    wanted.parameters_text = std::move(text).value();
  }
  return ask_nodes(
      wish.whom, wish.as_json,
      [&](ask::Nodes& nodes) { return ask::load_component(nodes, wish.whom.container, wanted); },
      [](const json& reply) {
        print_text("Loaded component %d as '%s'%s\n", reply["id"].get<int>(), text_of(reply, "node").c_str(),
                   reply["managed"].get<bool>() ? (", " + text_of(reply, "state")).c_str() : "");
      });
}

int unload(const ComponentWish& wish) {
  return ask_nodes(
      wish.whom, wish.as_json,
      [&](ask::Nodes& nodes) { return ask::unload_component(nodes, wish.whom.container, wish.name); },
      [](const json& reply) {
        print_text("Unloaded component %d ('%s')\n", reply["id"].get<int>(), text_of(reply, "node").c_str());
        if (!reply["image_closed"].get<bool>())
          print_text("Its library stays loaded while it is in use by: %s\n", text_of(reply, "held_by").c_str());
      });
}

int info(const ComponentWish& wish) {
  if (wish.doc) return component_reference(wish.name, wish.as_json);
  if (wish.name.empty())
    return complain_of_usage(
        {"component info", "component is required", "name one of `nacelle component list`, or add --doc"});
  if (wish.name.find("::") != std::string::npos)
    return complain_of_usage({"component info " + wish.name, "this is a class, not a component of a container",
                              "add --doc for what the class declares"});
  return component_info(wish.whom, wish.name, wish.as_json);
}

/// Lists the components in the plugin search path of launch files. Needs no container.
int types(const ComponentWish& wish) {
  const auto places = program_places();
  runtime::PluginIndex index{places.component_folders};
  const auto entries = index.entries();
  if (entries.empty()) return complain_of_no_plugins(places);
  json rows = json::array();
  std::string package;
  for (const auto& entry : entries) {
    rows.push_back({{"package", entry.package}, {"plugin", entry.class_name}, {"library", entry.file}});
    if (wish.as_json) continue;
    if (entry.package != package) print_text("%s\n", entry.package.c_str());
    print_text("  %s\n", entry.class_name.c_str());
    package = entry.package;
  }
  if (wish.as_json) std::printf("%s\n", rows.dump().c_str());
  return kDone;
}

}  // namespace

void add_component_commands(Command& root) {
  Command& group = root.add("component", "list, load and unload components of a running container");
  auto wish = std::make_shared<ComponentWish>();

  Command& list_command =
      group.add("list", "list loaded components (id, node, state), and libraries that are still in use");
  add_common_options(list_command, wish->whom, wish->as_json);
  list_command.flag("-v,--verbose", wish->details, "the plugin too");
  list_command.runs([wish] { return list(*wish); });

  Command& info_command = group.add("info", "show a component's plugin, parameters, state and callbacks");
  info_command
      .option("component", wish->name, "name or id; with --doc pkg::Class, or nothing for all that are installed")
      .names_a(Names::Node)
      .names_a_with("--doc", Names::Plugin);
  add_common_options(info_command, wish->whom, wish->as_json);
  info_command
      .flag("--doc", wish->doc,
            "what an installed class declares, as Markdown: topics, services, actions, parameters, devices; needs no "
            "container")
      .not_with("--container")
      .not_with("--remote");
  info_command.runs([wish] { return info(*wish); });

  Command& types_command = group.add("types", "list the installed plugins by package; needs no container");
  types_command.flag("--json", wish->as_json, "print JSON, with the libraries");
  types_command.runs([wish] { return types(*wish); });

  Command& load_command = group.add("load", "load a component of the launch file by name, or any plugin by class");
  load_command.option("component", wish->name, "NAME of the launch file, or pkg::Class")
      .required()
      .names_a(Names::Plugin);
  load_command.option("-n,--name", wish->new_name, "the node's name, for a plugin");
  load_command.option("--namespace", wish->name_space, "the node's namespace, for a plugin");
  load_command.option("-p,--parameter", wish->parameters, "a parameter of the plugin; may be repeated")
      .value("NAME:=VALUE")
      .checked(wrong_assignment);
  load_command.option("-r,--remap", wish->remaps, "a remap of a topic or service of the plugin")
      .value("FROM:=TO")
      .checked(wrong_remap);
  load_command.option("--params-file", wish->params_file, "a ROS 2 parameter file").value("FILE").names_a(Names::File);
  add_common_options(load_command, wish->whom, wish->as_json);
  load_command.runs([wish] { return load(*wish); });

  Command& unload_command = group.add("unload", "unload a component and its library");
  unload_command.option("component", wish->name, "name or id").required().names_a(Names::Node);
  add_common_options(unload_command, wish->whom, wish->as_json);
  unload_command.runs([wish] { return unload(*wish); });
}

}  // namespace nacelle::cli
