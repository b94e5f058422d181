// SPDX-License-Identifier: Apache-2.0
#include "component_info.hpp"

#include <cstdio>
#include <map>

#include "asking.hpp"
#include "nacelle/ask/composition.hpp"
#include "nacelle/ask/parameters.hpp"
#include "node_view.hpp"
#include "program.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

// A container that loads another component meanwhile answers when that is done.
constexpr Duration kBusyLimit = 90s;

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
  for (const auto& rule : reply["remaps"]) std::printf("  remap: %s\n", rule.get<std::string>().c_str());
  for (const auto& qos : reply["qos_overrides"]) {
    std::printf("  qos of: %s of %s\n", qos["publisher"].get<bool>() ? "publisher" : "subscription",
                text_of(qos, "topic").c_str());
  }
  if (!reply["parameters"].empty()) std::printf("  parameters given:\n");
  for (const auto& [name, value] : reply["parameters"].items())
    std::printf("    %s: %s\n", name.c_str(), value.dump().c_str());
  std::printf("  thread: %s\n", words_of_thread(reply["thread"]).c_str());
  const json& on_fault = reply["on_fault"];
  const std::string policy = text_of(on_fault, "policy");
  std::printf("  on fault: %s", policy.c_str());
  if (policy == "restart")
    std::printf(", at most %u times, %g s before each", on_fault["max_restarts"].get<unsigned>(),
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
  if (!words.empty()) std::printf("  callbacks: %s\n", join(words).c_str());
}

void print_own(const json& reply) {
  std::printf("%s\n  id: %d\n  plugin: %s\n  library: %s\n", text_of(reply, "node").c_str(), reply["id"].get<int>(),
              text_of(reply, "plugin").c_str(), text_of(reply, "library").c_str());
  if (reply["managed"].get<bool>()) {
    std::printf("  state: %s [%d]\n", text_of(reply, "state").c_str(), reply["state_id"].get<int>());
  } else {
    std::printf("  state: none, a plain node\n");
  }
  std::printf("  process: %s\n", reply["isolated"].get<bool>() ? "its own" : "the container's");
  std::printf("  namespace: %s\n", text_of(reply, "namespace").c_str());
  if (reply.contains("thread")) print_given(reply);
  if (reply["callbacks"].is_array()) print_callbacks(reply["callbacks"]);
  if (reply.contains("fault"))
    std::printf("  faulted: %s: %s\n", text_of(reply["fault"], "code").c_str(),
                text_of(reply["fault"], "text").c_str());
  for (const auto& fault : reply.value("open_faults", json::array()))
    std::printf("  open fault: %s: %s\n", text_of(fault, "code").c_str(), text_of(fault, "text").c_str());
  std::printf("  faults so far: %zu\n", reply["faults"].size());
}

// --- over the network ------------------------------------------------------------------------------------------------

void warn(const Problem& problem) { std::fprintf(stderr, "nacelle: warning: %s\n", problem.text().c_str()); }

void print_remote(const json& reply, const NodeView& view) {
  std::printf("%s\n  id: %d\n  container: /%s\n", text_of(reply, "node").c_str(), reply["id"].get<int>(),
              text_of(reply, "container").c_str());
  if (!reply["managed"].get<bool>()) {
    std::printf("  state: none, a plain node\n");
  } else if (reply.contains("state_id")) {
    std::printf("  state: %s [%d]\n", text_of(reply, "state").c_str(), reply["state_id"].get<int>());
  }
  for (const char* const key : {"namespace", "host", "pid", "enclave"}) {
    if (reply.contains(key)) std::printf("  %s: %s\n", key, text_of(reply, key).c_str());
  }
  if (const auto values = reply.find("parameter_values"); values != reply.end()) {
    std::printf("  parameters:\n");
    for (const auto& [name, value] : values->items()) std::printf("    %s: %s\n", name.c_str(), value.dump().c_str());
  }
  print(view);
  std::printf("  not shown with --remote: plugin, library, what it was given, thread, callbacks, faults\n");
  std::fflush(stdout);
  tell_left_out(view.left_out, "`nacelle node info --all --remote`");
}

/// What the container says of the component, and what the network says of its process.
Result<json, Problem> told_of(control::Client& client, const std::string& container, const std::string& name) {
  ask::Nodes nodes{client};
  auto row = ask::find_component(nodes, container, name);
  if (!row) return err(row.error());
  const std::string node = text_of(row.value(), "node");
  json told{{"container", row.value()["container"]},
            {"id", row.value()["id"]},
            {"node", node},
            {"managed", row.value()["managed"]},
            {"state", row.value()["state"]}};
  auto process = client.call({{"verb", "node.process"}, {"node", node}}, kAnswerLimit);
  if (!process) return err(process.error());
  told.update(process.value()["process"]);
  if (!told["managed"].get<bool>()) return told;
  if (const auto state = ask::lifecycle_state(nodes, node); state) {
    told["state"] = state.value()["state"];
    told["state_id"] = state.value()["state_id"];
  } else {
    warn(state.error());
  }
  return told;
}

/// That is joined by what `node info` and `param dump` show of the node.
int info_remotely(const Whom& whom, const std::string& name, bool as_json) {
  auto client = connect(whom);
  if (!client) return client.error();
  auto told = told_of(client.value(), whom.container, name);
  if (!told) return complain(told.error());
  json& reply = told.value();
  const std::string node = text_of(reply, "node");
  const auto graph = client.value().call({{"verb", "graph"}}, kAnswerLimit);
  if (!graph) return complain(graph.error());
  for (const auto& row : graph.value()["nodes"]) {
    if (row["node"] != node || !row["parameters"].get<bool>() || reply.contains("parameter_values")) continue;
    // A node that keeps these to itself is shown without.
    ask::Nodes nodes{client.value()};
    const auto parameters = ask::list_parameters(nodes, node);
    if (!parameters) {
      warn(parameters.error());
      break;
    }
    json& values = reply["parameter_values"] = json::object();
    for (const auto& parameter : parameters.value()) values[text_of(parameter, "name")] = parameter["value"];
  }
  const NodeView view = view_of(graph.value(), node, false, as_json);
  if (!as_json) {
    print_remote(reply, view);
    return kDone;
  }
  add_to_json(reply, view);
  std::printf("%s\n", reply.dump().c_str());
  return kDone;
}

}  // namespace

int component_info(const Whom& whom, const std::string& name, bool as_json) {
  if (whom.is_remote()) return info_remotely(whom, name, as_json);
  return ask(whom, {{"verb", "component.info"}, {"name", name}}, as_json, print_own, kBusyLimit);
}

}  // namespace nacelle::cli
