// SPDX-License-Identifier: Apache-2.0
// `completion`, the hidden command that its scripts call, and the man page: all that is generated from the tree of commands.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>

#include "ask/composition.hpp"
#include "ask/frames.hpp"
#include "ask/parameters.hpp"
#include "cli/completion.hpp"
#include "cli/man_page.hpp"
#include "cli/program.hpp"
#include "control/socket_path.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/base/printable.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

// Completion is interactive, so it must be fast.
constexpr Duration kCompletionLimit = 200ms;

struct CompletionWish {
  std::string shell = "bash", output;
  std::vector<std::string> words;
};

std::vector<std::string> container_names() {
  std::vector<std::string> names;
  for (const auto& found : control::running_containers(control::socket_places_from_environment()))
    names.push_back(found.name);
  return names;
}

/// Connects to the container that is meant; nothing if there is none.
std::optional<control::Client> connect_to(const std::string& container) {
  std::optional<std::string> wanted;
  if (!container.empty()) wanted = container;
  if (const char* const variable = std::getenv("NACELLE_CONTAINER");
      !wanted && variable != nullptr && *variable != '\0')
    wanted = variable;
  const auto found =
      control::choose_container(control::running_containers(control::socket_places_from_environment()), wanted);
  if (!found) return std::nullopt;
  auto client = control::Client::connect(found.value().path);
  if (!client) return std::nullopt;
  return std::move(client).value();
}

std::vector<std::string> parameters_of(const std::string& container, const std::string& name) {
  auto client = connect_to(container);
  if (!client) return {};
  ask::Nodes nodes{*client, kCompletionLimit, 0s};
  const auto node = nodes.find(name);
  if (!node) return {};
  const auto names = ask::parameter_names(nodes, node.value());
  return names ? names.value() : std::vector<std::string>{};
}

/// Returns the answer of a verb; null if there is none, or it takes too long.
json answer_of(const std::string& container, const std::function<Result<json, Problem>(ask::Nodes&)>& question) {
  auto client = connect_to(container);
  if (!client) return nullptr;
  ask::Nodes nodes{*client, kCompletionLimit, 0s};
  auto answer = question(nodes);
  return answer ? std::move(answer).value() : json{nullptr};
}

std::vector<std::string> texts(const json& reply, const char* list, std::initializer_list<const char*> keys) {
  std::vector<std::string> all;
  if (!reply.is_object() || !reply.contains(list)) return all;
  for (const auto& row : reply[list]) {
    for (const char* const key : keys) {
      const std::string text = row.value(key, "");
      // A part that begins with '_' is not for people.
      if (!text.empty() && text.find("/_") == std::string::npos) all.push_back(text);
    }
  }
  return all;
}

/// An action's goals go through the service <action>/_action/send_goal.
std::vector<std::string> actions(const json& graph) {
  constexpr std::string_view kEnd = "/_action/send_goal";
  std::vector<std::string> all;
  if (!graph.is_object() || !graph.contains("services")) return all;
  for (const auto& row : graph["services"]) {
    const std::string name = row.value("name", "");
    if (name.size() > kEnd.size() && name.compare(name.size() - kEnd.size(), kEnd.size(), kEnd) == 0)
      all.push_back(name.substr(0, name.size() - kEnd.size()));
  }
  return all;
}

std::vector<std::string> types(std::string_view kind) {
  msgs::TypeLibrary library{program_places().message_folders};
  std::vector<std::string> all;
  for (const auto& package : library.packages()) {
    auto names = library.names(package, false);
    if (!names) continue;
    for (const auto& name : names.value()) {
      if (name.find(kind) != std::string::npos) all.push_back(name);
    }
  }
  return all;
}

std::vector<std::string> names_for(const NameQuestion& question) {
  const auto told = [&](const auto& verb) { return answer_of(question.container, verb); };
  const auto graph = [](ask::Nodes& nodes) { return nodes.graph(); };
  const auto components = [](ask::Nodes& nodes) { return ask::list_components(nodes, ""); };
  const auto frames = [](ask::Nodes& nodes) { return ask::list_frames(nodes, ""); };
  switch (question.names) {
    case Names::Topic: return texts(told(graph), "endpoints", {"topic"});
    case Names::Node: return texts(told(components), "components", {"node"});
    case Names::Service: return texts(told(graph), "services", {"name"});
    case Names::Action: return actions(told(graph));
    case Names::Frame: return texts(told(frames), "frames", {"child", "parent"});
    case Names::Parameter: {
      if (question.positional.empty()) return {};
      return parameters_of(question.container, question.positional.front());
    }
    case Names::Type: return types("/msg/");
    case Names::ServiceType: return types("/srv/");
    case Names::ActionType: return types("/action/");
    case Names::Plugin: return runtime::PluginIndex{program_places().component_folders}.class_names();
    case Names::Nothing:
    case Names::File: break;
  }
  return {};
}

int complete(const Command& root, const CompletionWish& wish) {
  std::vector<std::string> seen;
  for (const auto& candidate : completions(root, wish.words, names_for, container_names)) {
    if (std::find(seen.begin(), seen.end(), candidate.word) != seen.end()) continue;
    seen.push_back(candidate.word);
    std::printf("%s\t%s\n", printable_line(candidate.word).c_str(), printable_line(candidate.what).c_str());
  }
  return kDone;
}

int write(const std::string& output, const std::string& text) {
  if (output.empty()) return std::fputs(text.c_str(), stdout) >= 0 ? kDone : kFailed;
  const auto written = write_whole_file(output, text);
  return written ? kDone : complain(written.error());
}

json tree_of(const Command& command) {
  json below = json::array();
  for (const Command& one : command.subcommands()) {
    if (!one.is_hidden()) below.push_back(tree_of(one));
  }
  return {{"name", command.name()},
          {"what", command.what()},
          {"runs", static_cast<bool>(command.body())},
          {"subcommands", std::move(below)}};
}

}  // namespace

void add_completion_command(Command& root) {
  auto wish = std::make_shared<CompletionWish>();
  Command& completion =
      root.add("completion", "print the completion script of a shell: source <(nacelle completion bash)");
  completion.option("shell", wish->shell, "bash, zsh or fish").one_of({"bash", "zsh", "fish"});
  completion.option("-o,--output", wish->output, "write to this file instead of stdout").names_a(Names::File);
  completion.runs([wish] { return write(wish->output, completion_script(wish->shell)); });

  Command& asked = root.add("__complete", "what may follow these words").hidden();
  asked.option("words", wish->words, "behind --, the last one being written");
  asked.runs([wish, &root] { return complete(root, *wish); });

  Command& manual = root.add("man-page", "print the manual page in roff format").hidden();
  manual.option("-o,--output", wish->output, "write to this file instead of stdout").names_a(Names::File);
  manual.runs([wish, &root] { return write(wish->output, man_page(root, NACELLE_VERSION)); });

  Command& tree = root.add("command-tree", "print the names of all commands, as JSON").hidden();
  tree.runs([&root] { return write("", tree_of(root).dump() + "\n"); });
}

}  // namespace nacelle::cli
