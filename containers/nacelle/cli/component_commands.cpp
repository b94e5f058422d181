// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "program.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

// A component may take its time to find its device; the container itself gives it up after half a minute.
constexpr Duration kComponentLimit = 90s;

struct Wish {
  std::string container, name, new_name, name_space, params_file, transition;
  std::vector<std::string> parameters, remaps;
  bool as_json = false, details = false;
};

/// One request; on success `show` prints the reply.
int ask(const Wish& wish, const json& request, const std::function<void(const json&)>& show) {
  auto client = connect(wish.container);
  if (!client) return client.error();
  auto reply = client.value().call(request, kComponentLimit);
  if (!reply) return complain(reply.error());
  for (const auto& warning : reply.value().value("warnings", json::array()))
    std::fprintf(stderr, "nacelle: warning: %s\n", warning.get<std::string>().c_str());
  if (wish.as_json) {
    reply.value().erase("ok");
    std::printf("%s\n", reply.value().dump().c_str());
  } else {
    show(reply.value());
  }
  return kDone;
}

std::string text_of(const json& row, const char* key) { return row.value(key, ""); }

int list(const Wish& wish) {
  return ask(wish, {{"verb", "component.list"}}, [&](const json& reply) {
    std::printf("/%s\n", text_of(reply, "container").c_str());
    for (const auto& row : reply["components"]) {
      std::printf("  %d  %s", row["id"].get<int>(), text_of(row, "node").c_str());
      std::printf("  %s", row["managed"].get<bool>() ? text_of(row, "state").c_str() : "node");
      if (wish.details) std::printf("  %s", text_of(row, "plugin").c_str());
      if (row.contains("fault"))
        std::printf("  faulted: %s: %s", text_of(row["fault"], "code").c_str(), text_of(row["fault"], "text").c_str());
      std::printf("\n");
    }
    for (const auto& image : reply["kept_images"]) {
      std::printf("  image kept: %s of %s, held by %s\n", text_of(image, "library").c_str(),
                  text_of(image, "node").c_str(), text_of(image, "held_by").c_str());
    }
  });
}

int load(const Wish& wish) {
  json request;
  // A class name has '::'; a name of the launch file has not.
  const bool is_plugin = wish.name.find("::") != std::string::npos;
  const bool has_options = !wish.new_name.empty() || !wish.name_space.empty() || !wish.parameters.empty() ||
                           !wish.remaps.empty() || !wish.params_file.empty();
  if (!is_plugin) {
    if (has_options) {
      complain({"component load " + wish.name, "it comes with the launch file's parameters and remaps",
                "options belong to a plugin: pkg::Class --name N"});
      return kUsage;
    }
    request = {{"verb", "component.load"}, {"name", wish.name}};
  } else {
    request = {{"verb", "component.load_plugin"}, {"plugin", wish.name},           {"name", wish.new_name},
               {"namespace", wish.name_space},    {"parameters", wish.parameters}, {"remaps", wish.remaps}};
    // The container reads the file, and its working directory is another one.
    if (!wish.params_file.empty()) request["params_file"] = std::filesystem::absolute(wish.params_file).string();
  }
  return ask(wish, request, [](const json& reply) {
    std::printf("Loaded component %d as '%s'%s\n", reply["id"].get<int>(), text_of(reply, "node").c_str(),
                reply["managed"].get<bool>() ? (", " + text_of(reply, "state")).c_str() : "");
  });
}

int unload(const Wish& wish) {
  return ask(wish, {{"verb", "component.unload"}, {"name", wish.name}}, [](const json& reply) {
    std::printf("Unloaded component %d ('%s')\n", reply["id"].get<int>(), text_of(reply, "node").c_str());
    if (!reply["image_closed"].get<bool>())
      std::printf("Its library stays until it is free: held by %s\n", text_of(reply, "held_by").c_str());
  });
}

int get_state(const Wish& wish) {
  return ask(wish, {{"verb", "lifecycle.get"}, {"name", wish.name}}, [](const json& reply) {
    std::printf("%s [%d]\n", text_of(reply, "state").c_str(), reply["id"].get<int>());
  });
}

int set_state(const Wish& wish) {
  return ask(wish, {{"verb", "lifecycle.set"}, {"name", wish.name}, {"transition", wish.transition}},
             [](const json&) { std::printf("Transitioning successful\n"); });
}

/// What is wrong with `text` as name:=value.
std::string wrong_assignment(const std::string& text) {
  return text.find(":=") == std::string::npos ? "'" + text + "' has no ':='" : std::string{};
}

}  // namespace

void add_component_commands(Command& root) {
  Command& group = root.add("component", "list, load and unload components of a running container");
  auto wish = std::make_shared<Wish>();

  Command& list_command =
      group.add("list", "the loaded components: id, node and state; libraries that are kept, and by whom");
  add_common_options(list_command, wish->container, wish->as_json);
  list_command.flag("-v,--verbose", wish->details, "the plugin too");
  list_command.runs([wish] { return list(*wish); });

  Command& load_command = group.add("load", "load a component of the launch file by name, or any plugin by class");
  load_command.option("component", wish->name, "NAME of the launch file, or pkg::Class")
      .required()
      .names_a(Names::Plugin);
  load_command.option("-n,--name", wish->new_name, "the node's name (of a plugin)");
  load_command.option("--namespace", wish->name_space, "the node's namespace (of a plugin)");
  load_command.option("-p,--parameter", wish->parameters, "k:=v").checked(wrong_assignment);
  load_command.option("-r,--remap", wish->remaps, "from:=to").checked(wrong_assignment);
  load_command.option("--params-file", wish->params_file, "a ROS 2 parameter file")
      .names_a(Names::File)
      .checked([](const std::string& path) {
        return std::filesystem::is_regular_file(path) ? std::string{} : "File does not exist: " + path;
      });
  add_common_options(load_command, wish->container, wish->as_json);
  load_command.runs([wish] { return load(*wish); });

  Command& unload_command = group.add("unload", "take a component out, its library too");
  unload_command.option("component", wish->name, "name or id").required().names_a(Names::Node);
  add_common_options(unload_command, wish->container, wish->as_json);
  unload_command.runs([wish] { return unload(*wish); });
}

void add_lifecycle_commands(Command& root) {
  Command& group = root.add("lifecycle", "see and change the state of a component");
  auto wish = std::make_shared<Wish>();

  Command& get_command = group.add("get", "the state of a component");
  get_command.option("node", wish->name, "name or id").required().names_a(Names::Node);
  add_common_options(get_command, wish->container, wish->as_json);
  get_command.runs([wish] { return get_state(*wish); });

  Command& set_command = group.add("set", "trigger a transition of a component");
  set_command.option("node", wish->name, "name or id").required().names_a(Names::Node);
  set_command.option("transition", wish->transition, "configure, activate, deactivate, cleanup or shutdown")
      .required()
      .one_of({"configure", "activate", "deactivate", "cleanup", "shutdown"});
  add_common_options(set_command, wish->container, wish->as_json);
  set_command.runs([wish] { return set_state(*wish); });
}

}  // namespace nacelle::cli
