// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
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

void add_common(CLI::App* command, const std::shared_ptr<Wish>& wish) {
  command->add_option("--container", wish->container, "which container, if several run (or NACELLE_CONTAINER)");
  command->add_flag("--json", wish->as_json, "the answer as JSON");
}

}  // namespace

void add_component_commands(CLI::App& app, int& exit_code) {
  CLI::App* const group = app.add_subcommand("component", "list, load and unload components of a running container");
  group->require_subcommand(1);
  auto wish = std::make_shared<Wish>();

  CLI::App* const list_command = group->add_subcommand(
      "list", "the loaded components: id, node and state; libraries that are kept, and by whom");
  add_common(list_command, wish);
  list_command->add_flag("-v,--verbose", wish->details, "the plugin too");
  list_command->callback([wish, &exit_code] { exit_code = list(*wish); });

  CLI::App* const load_command =
      group->add_subcommand("load", "load a component of the launch file by name, or any plugin by class");
  const CLI::Validator assignment{[](const std::string& text) {
                                    return text.find(":=") == std::string::npos ? "'" + text + "' has no ':='"
                                                                                : std::string{};
                                  },
                                  ""};
  load_command->add_option("component", wish->name, "NAME of the launch file, or pkg::Class")->required();
  load_command->add_option("-n,--name", wish->new_name, "the node's name (of a plugin)");
  load_command->add_option("--namespace", wish->name_space, "the node's namespace (of a plugin)");
  load_command->add_option("-p,--parameter", wish->parameters, "k:=v")
      ->expected(1)
      ->allow_extra_args(false)
      ->check(assignment)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  load_command->add_option("-r,--remap", wish->remaps, "from:=to")
      ->expected(1)
      ->allow_extra_args(false)
      ->check(assignment)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  load_command->add_option("--params-file", wish->params_file, "a ROS 2 parameter file")->check(CLI::ExistingFile);
  add_common(load_command, wish);
  load_command->callback([wish, &exit_code] { exit_code = load(*wish); });

  CLI::App* const unload_command = group->add_subcommand("unload", "take a component out, its library too");
  unload_command->add_option("component", wish->name, "name or id")->required();
  add_common(unload_command, wish);
  unload_command->callback([wish, &exit_code] { exit_code = unload(*wish); });
}

void add_lifecycle_commands(CLI::App& app, int& exit_code) {
  CLI::App* const group = app.add_subcommand("lifecycle", "see and change the state of a component");
  group->require_subcommand(1);
  auto wish = std::make_shared<Wish>();

  CLI::App* const get_command = group->add_subcommand("get", "the state of a component");
  get_command->add_option("node", wish->name, "name or id")->required();
  add_common(get_command, wish);
  get_command->callback([wish, &exit_code] { exit_code = get_state(*wish); });

  CLI::App* const set_command = group->add_subcommand("set", "trigger a transition of a component");
  set_command->add_option("node", wish->name, "name or id")->required();
  set_command->add_option("transition", wish->transition, "configure, activate, deactivate, cleanup or shutdown")
      ->required()
      ->check(CLI::IsMember({"configure", "activate", "deactivate", "cleanup", "shutdown"}));
  add_common(set_command, wish);
  set_command->callback([wish, &exit_code] { exit_code = set_state(*wish); });
}

}  // namespace nacelle::cli
