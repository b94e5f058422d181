// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdio>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>

#include "ask/faults.hpp"
#include "cli/asking.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct FaultsWish {
  Whom whom;
  bool as_json = false;
};

std::string clock_time(std::int64_t time_ns) {
  const std::time_t seconds = time_ns / 1'000'000'000;
  std::tm local{};
  ::localtime_r(&seconds, &local);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%H:%M:%S", &local);
  std::array<char, 32> all{};
  std::snprintf(all.data(), all.size(), "%s.%03d", text.data(), static_cast<int>(time_ns / 1'000'000 % 1000));
  return all.data();
}

std::string where_of(const json& event) {
  const std::string callback = event.value("callback", "");
  return callback.empty() ? "" : "  (in " + callback + ")";
}

std::string how_it_ended(const json& event) {
  if (!event.contains("open")) return "";
  if (event["open"].get<bool>()) return "  (lasts)";
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "  (over after %.1f s)", event["lasted_s"].get<double>());
  return text.data();
}

void print_faults(const json& reply) {
  if (!reply["robot_stopped_by"].is_null())
    print_text("the robot was stopped by %s\n", reply["robot_stopped_by"].get<std::string>().c_str());
  if (!reply["last_crash"].is_null())
    print_text("a run before crashed: %s\n", reply["last_crash"]["text"].get<std::string>().c_str());
  if (!reply["container"].is_null())
    print_text("the container is faulted: %s\n", fault_text(reply["container"]).c_str());
  bool any = false;
  for (const auto& row : reply["left_out"]) {
    any = true;
    print_text("%s  left out: %s\n", row["node"].get<std::string>().c_str(), row["why"].get<std::string>().c_str());
  }
  for (const auto& row : reply["components"]) {
    const bool faulted = row.contains("fault");
    const json open_faults = row.value("open_faults", json::array());
    any = any || faulted || !open_faults.empty();
    print_text("%s  %s%s", row["node"].get<std::string>().c_str(), row["state"].get<std::string>().c_str(),
               faulted ? "  faulted: " : "");
    if (faulted) {
      print_text("%s%s", fault_text(row["fault"]).c_str(), row.contains("last") ? where_of(row["last"]).c_str() : "");
    }
    for (const auto& fault : open_faults) print_text("  open fault: %s", fault_text(fault).c_str());
    if (!faulted && !open_faults.empty()) {
      std::printf("\n  the component repairs this itself; on_fault is not applied\n");
      continue;
    }
    print_text("\n  on_fault: %s", row["policy"].get<std::string>().c_str());
    if (row["policy"] == "restart")
      print_text(", restarted %d of %d times", row["restarts"].get<int>(), row["max_restarts"].get<int>());
    if (row.contains("next_restart_s")) print_text(", the next in %.1f s", row["next_restart_s"].get<double>());
    std::printf("\n");
  }
  if (!any) std::printf("no component is faulted\n");
  if (reply["history"].empty()) return;
  std::printf("what happened:\n");
  for (const auto& event : reply["history"]) {
    print_text("  %s  %s  %s%s%s\n", clock_time(event["time_ns"].get<std::int64_t>()).c_str(),
               event["node"].get<std::string>().c_str(), fault_text(event).c_str(), where_of(event).c_str(),
               how_it_ended(event).c_str());
  }
}

int faults(const FaultsWish& wish) {
  constexpr Duration kRestart = 80s;  // the main thread takes no question meanwhile
  return ask_nodes(
      wish.whom, wish.as_json, [&](ask::Nodes& nodes) { return ask::list_faults(nodes, wish.whom.container); },
      print_faults, kRestart);
}

}  // namespace

void add_faults_command(Command& root) {
  auto wish = std::make_shared<FaultsWish>();
  Command& command = root.add("faults", "show faulted components, the cause, and how the fault is handled");
  add_common_options(command, wish->whom, wish->as_json);
  command.runs([wish] { return faults(*wish); });
}

}  // namespace nacelle::cli
