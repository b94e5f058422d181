// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/inert_launch.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/names.hpp"
#include "nacelle/qos/compatibility.hpp"
#include "nacelle/qos/text.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct QosWish {
  std::string file, offered, requested;
  std::vector<std::string> arguments;
  bool as_json = false;
};

void print(const json& object) { std::printf("%s\n", object.dump(2).c_str()); }

// --- explain ------------------------------------------------------------------------------------------------------------

template <typename T>
std::optional<Problem> set(QoS& qos, QoS& (QoS::*setter)(T), Result<T, Problem> value) {
  if (!value) return value.error();
  (qos.*setter)(value.value());
  return std::nullopt;
}

std::optional<Problem> set_one(QoS& qos, const std::string& key, const std::string& value) {
  if (key == "reliability") return set(qos, &QoS::reliability, parse_reliability(value));
  if (key == "durability") return set(qos, &QoS::durability, parse_durability(value));
  if (key == "liveliness") return set(qos, &QoS::liveliness, parse_liveliness(value));
  if (key == "deadline") return set(qos, &QoS::deadline, parse_duration(value));
  if (key == "lease") return set(qos, &QoS::liveliness_lease_duration, parse_duration(value));
  return Problem{"", "there is no policy '" + key + "' that could keep a pair apart",
                 suggestion(key, {"reliability", "durability", "deadline", "liveliness", "lease"})};
}

/// "reliability=best_effort,deadline=100ms"; what is absent is ROS 2's default: reliable, volatile, automatic, infinite.
Result<QoS, Problem> parse_side(const char* option, const std::string& text) {
  QoS qos = QoS(10).resolved();
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string item = text.substr(at, comma - at);
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == item.size()) {
      return err(Problem{option, "'" + item + "' is not key=value", "e.g. reliability=best_effort,deadline=100ms"});
    }
    if (auto problem = set_one(qos, item.substr(0, equals), item.substr(equals + 1))) {
      problem->where = option;
      return err(std::move(*problem));
    }
    at = comma + 1;
  }
  return qos;
}

int explain(const QosWish& wish) {
  const auto offered = parse_side("--offered", wish.offered), requested = parse_side("--requested", wish.requested);
  for (const auto* side : {&offered, &requested}) {
    if (*side) continue;
    complain(side->error());
    return kUsage;
  }
  const Compatibility answer = check(offered.value(), requested.value());
  const char* const verdict = answer.verdict == Verdict::Ok        ? "ok"
                              : answer.verdict == Verdict::Warning ? "warning"
                                                                   : "error";
  if (!wish.as_json) {
    print_text("%s\n", verdict);
    for (const auto& clash : answer.clashes) print_text("  %s\n", clash.text().c_str());
    return kDone;
  }
  json reasons = json::array();
  for (const auto& clash : answer.clashes) {
    // The word that is typed here and in launch files.
    const std::string policy = clash.policy == "liveliness_lease_duration" ? "lease" : clash.policy;
    reasons.push_back(
        {{"policy", policy}, {"offered", clash.offered}, {"requested", clash.requested}, {"change", clash.change}});
  }
  print({{"verdict", verdict}, {"reasons", std::move(reasons)}});
  return kDone;
}

// --- check --------------------------------------------------------------------------------------------------------------

/// Makes every component, which declares its endpoints and touches no hardware (design D3), and starts none.
int check_launch_file(const QosWish& wish) {
  const auto loaded = open_inert_launch(wish.file, wish.arguments);
  if (!loaded) return loaded.error();
  const InertLaunch& robot = *loaded.value();
  for (const auto& component : robot.inert.loaded) {
    if (component.failure)
      return complain({component.plan->where, component.failure->where.text() + ": " + component.failure->what,
                       component.failure->way_out});
  }
  const auto clashes = robot.inert.container->clashes();
  const std::size_t components = robot.plan.components.size(), streams = stream_count(*robot.inert.container);
  if (wish.as_json) {
    json rows = json::array();
    for (const auto& clash : clashes) {
      rows.push_back({{"topic", clash.topic},
                      {"publisher", clash.writer_node},
                      {"subscription", clash.reader_node},
                      {"policy", clash.policy},
                      {"offered", clash.offered},
                      {"requested", clash.requested},
                      {"change", clash.change},
                      {"other_publishers", clash.other_writers}});
    }
    print({{"verdict", clashes.empty() ? "ok" : "error"},
           {"components", components},
           {"streams", streams},
           {"clashes", std::move(rows)}});
  } else {
    for (const auto& clash : clashes) print_text("%s\n", clash.text().c_str());
    print_text("%zu components, %zu streams: %s\n", components, streams,
               clashes.empty() ? "every publisher and subscription fits"
                               : fmt::format("{} clash{}", clashes.size(), clashes.size() == 1 ? "" : "es").c_str());
  }
  return clashes.empty() ? kDone : kFailed;
}

}  // namespace

void add_qos_commands(Command& root) {
  const auto wish = std::make_shared<QosWish>();
  Command& qos = root.add("qos", "check whether publishers and subscriptions are compatible");

  Command& check = qos.add("check", "check every pair of a launch file without starting anything");
  check.option("launch_file", wish->file, "a launch file").required().names_a(Names::File);
  check.option("arguments", wish->arguments, "name:=value for the file's arguments");
  check.flag("--json", wish->as_json, "print one JSON object");
  check.note("Exit codes: 0 all fit, 1 a pair clashes or a component cannot be made, 2 wrong usage.");
  check.runs([wish] { return check_launch_file(*wish); });

  Command& explain_one =
      qos.add("explain", "check whether a publisher's QoS satisfies a subscription's: ok, warning or error");
  explain_one.option("--offered", wish->offered, "the publisher's policies, k=v,k=v").required();
  explain_one.option("--requested", wish->requested, "the subscription's policies, k=v,k=v").required();
  explain_one.flag("--json", wish->as_json, "print one JSON object: verdict, reasons");
  explain_one.note(
      "Keys: reliability (reliable, best_effort, ...), durability (volatile, transient_local, ...), liveliness\n"
      "(automatic, manual_by_topic, ...), deadline and lease (100ms, 1s, infinite). Absent: reliable, volatile, "
      "automatic,\n"
      "infinite. The exit code is 0 whatever the answer, 2 for wrong usage.");
  explain_one.runs([wish] { return explain(*wish); });
}

}  // namespace nacelle::cli
