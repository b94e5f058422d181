// SPDX-License-Identifier: Apache-2.0
#include "ask/faults.hpp"

#include <utility>

namespace nacelle::ask {
namespace {

using nlohmann::json;

void simplify_event(json& event) {
  if (event["is_open_fault"].get<bool>()) event["open"] = event["lasted_s"].empty();
  event.erase("is_open_fault");
  unwrap(event, "lasted_s");
}

bool is_empty(const json& text) { return text.get_ref<const std::string&>().empty(); }

}  // namespace

Result<json, Problem> list_faults(Nodes& nodes, const std::string& container) {
  auto answer = nodes.ask_container(container, "get_faults", "nacelle_interfaces/srv/GetFaults");
  if (!answer) return answer;
  json& faults = answer.value();
  for (json& row : faults["components"]) {
    for (const char* const key : {"fault", "next_restart_s", "last"}) unwrap(row, key);
    if (row.contains("last")) simplify_event(row["last"]);
    if (row["open_faults"].empty()) row.erase("open_faults");
  }
  for (json& event : faults["history"]) simplify_event(event);
  const json& own = faults["container_fault"];
  json crash{{"text", faults["last_crash"]}, {"file", faults["last_crash_file"]}};
  return json{{"components", faults["components"]},
              {"history", faults["history"]},
              {"left_out", faults["left_out"]},
              {"container", own.empty() ? json(nullptr) : own.front()},
              {"robot_stopped_by", is_empty(faults["robot_stopped_by"]) ? json(nullptr) : faults["robot_stopped_by"]},
              {"last_crash", is_empty(faults["last_crash"]) ? json(nullptr) : std::move(crash)}};
}

Result<std::vector<std::string>, Problem> emergency_stops(Nodes& nodes, const std::string& container) {
  const auto answer = nodes.ask_container(container, "get_emergency_stops", "nacelle_interfaces/srv/GetEmergencyStops");
  if (!answer) return err(answer.error());
  return answer.value()["topics"].get<std::vector<std::string>>();
}

Result<json, Problem> release_emergency_stops(Nodes& nodes, const std::string& container, const std::string& topic) {
  const json topics = topic.empty() ? json::array() : json::array({topic});
  const auto answer = nodes.ask_container(container, "release_emergency_stops",
                                          "nacelle_interfaces/srv/ReleaseEmergencyStops", {{"topics", topics}});
  if (!answer) return err(answer.error());
  if (!answer.value()["success"].get<bool>()) return err(problem_of(answer.value()));
  json rows = json::array();
  for (const json& row : answer.value()["released"])
    rows.push_back({{"name", row["topic"]}, {"readers", row["readers"]}});
  return json{{"topics", rows}};
}

}  // namespace nacelle::ask
