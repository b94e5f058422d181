// SPDX-License-Identifier: Apache-2.0
#include "robot_commands/component_info.hpp"

#include <cstdio>
#include <map>

#include "ask/composition.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

// A container that restarts a component takes the question when that is done.
constexpr Duration kBusyLimit = 80s;

std::string words_of_thread(const json& thread) {
  if (!thread["own"].get<bool>()) return "the shared one";
  std::string words = "its own";
  if (const auto threads = thread["threads"].get<unsigned>(); threads != 1)
    words = std::to_string(threads) + " of " + words;
  if (const int priority = thread["priority"].get<int>(); priority != 0)
    words += ", priority " + std::to_string(priority);
  if (!thread["cpus"].empty()) words += ", cpus " + thread["cpus"].dump();
  return words;
}

void print_given(const json& reply) {
  for (const auto& rule : reply["remaps"]) print_text("  remap: %s\n", rule.get<std::string>().c_str());
  for (const auto& qos : reply["qos_overrides"]) {
    print_text("  qos of: %s of %s\n", qos["publisher"].get<bool>() ? "publisher" : "subscription",
               text_of(qos, "topic").c_str());
  }
  if (!reply["parameters"].empty()) std::printf("  parameters given:\n");
  for (const auto& [name, value] : reply["parameters"].items())
    print_text("    %s: %s\n", name.c_str(), value.dump().c_str());
  print_text("  thread: %s\n", words_of_thread(reply["thread"]).c_str());
  const json& on_fault = reply["on_fault"];
  const std::string policy = text_of(on_fault, "policy");
  print_text("  on fault: %s", policy.c_str());
  if (policy == "restart")
    print_text(", at most %u times, %g s before each", on_fault["max_restarts"].get<unsigned>(),
               on_fault["backoff_s"].get<double>());
  std::printf("\n");
}

void print_callbacks(const json& callbacks) {
  std::map<std::string, std::size_t> counts;
  for (const auto& callback : callbacks) ++counts[text_of(callback, "kind")];
  std::vector<std::string> words;
  words.reserve(counts.size());
  for (const auto& [kind, count] : counts)
    words.push_back(std::to_string(count) + " " + kind + (count == 1 ? "" : "s"));
  if (!words.empty()) print_text("  callbacks: %s\n", join(words).c_str());
}

void print_component(const json& reply) {
  print_text("%s\n  id: %d\n", text_of(reply, "node").c_str(), reply["id"].get<int>());
  const bool is_of_nacelle = reply.contains("plugin");
  if (is_of_nacelle)
    print_text("  plugin: %s\n  library: %s\n", text_of(reply, "plugin").c_str(), text_of(reply, "library").c_str());
  if (reply["managed"].get<bool>()) {
    print_text("  state: %s [%d]\n", text_of(reply, "state").c_str(), reply["state_id"].get<int>());
  } else {
    std::printf("  state: none, a plain node\n");
  }
  print_text("  container: /%s\n  namespace: %s\n", text_of(reply, "container").c_str(),
             text_of(reply, "namespace").c_str());
  if (!is_of_nacelle) return;
  print_text("  host: %s\n  process: %s\n", text_of(reply, "host").c_str(),
             reply["isolated"].get<bool>() ? "its own" : "the container's");
  for (const auto& node : reply.value("other_nodes", json::array()))
    print_text("  its node: %s\n", node.get<std::string>().c_str());
  if (reply.contains("thread")) print_given(reply);
  print_callbacks(reply["callbacks"]);
  if (reply.contains("fault")) print_text("  faulted: %s\n", fault_text(reply["fault"]).c_str());
  for (const auto& fault : reply.value("open_faults", json::array()))
    print_text("  open fault: %s\n", fault_text(fault).c_str());
  print_text("  faults so far: %zu\n", reply["faults"].size());
}

}  // namespace

int component_info(const Whom& whom, const std::string& name, bool as_json) {
  return ask_nodes(
      whom, as_json, [&](ask::Nodes& nodes) { return ask::component_info(nodes, whom.container, name); },
      print_component, kBusyLimit);
}

}  // namespace nacelle::cli
