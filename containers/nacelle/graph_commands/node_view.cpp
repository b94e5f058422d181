// SPDX-License-Identifier: Apache-2.0
#include "graph_commands/node_view.hpp"

#include <cctype>
#include <cstdio>

#include "cli/asking.hpp"
#include "cli/output.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

constexpr const char* kSections[] = {"Subscribers",     "Publishers",     "Service Servers",
                                     "Service Clients", "Action Servers", "Action Clients"};

/// "/dock" and "nav2_msgs/action/Dock" of what an action is made of: "/dock/_action/<part>", "nav2_msgs/action/Dock_<Part>".
bool note_action(NodeView::Section& section, const std::string& name, const std::string& type, const std::string& part,
                 const std::string& type_part) {
  const std::string ending = "/_action/" + part, type_ending = "_" + type_part;
  if (!name.ends_with(ending) || !type.ends_with(type_ending)) return false;
  section[name.substr(0, name.size() - ending.size())].insert(type.substr(0, type.size() - type_ending.size()));
  return true;
}

}  // namespace

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

void add_to_json(json& answer, const NodeView& view) {
  for (const char* title : kSections) {
    std::string key = title;
    for (char& c : key) c = c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    answer[key] = json::array();
    const auto section = view.sections.find(title);
    if (section == view.sections.end()) continue;
    for (const auto& [entry, types] : section->second) {
      answer[key].push_back({{"name", entry}, {"types", types}});
      if (view.standard.contains(entry)) answer[key].back()["standard"] = true;
    }
  }
}

void print(const NodeView& view) {
  for (const char* title : kSections) {
    print_text("  %s:\n", title);
    const auto section = view.sections.find(title);
    if (section == view.sections.end() || section->second.empty()) {
      std::printf("\n");
      continue;
    }
    for (const auto& [entry, types] : section->second)
      print_text("    %s: %s\n", entry.c_str(), join({types.begin(), types.end()}).c_str());
  }
}

}  // namespace nacelle::cli
