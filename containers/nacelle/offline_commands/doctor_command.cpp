// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "ask/composition.hpp"
#include "cli/inert_launch.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "cli/version.hpp"
#include "doctor/checks.hpp"
#include "nacelle/base/problem_json.hpp"
#include "offline_commands/commands.hpp"

namespace nacelle::cli {
namespace {

using doctor::Finding;
using doctor::Findings;
using doctor::Severity;
using nlohmann::json;

struct DoctorWish {
  std::string file;
  std::vector<std::string> arguments;
  bool as_json = false;
};

/// The devices of the plan, and those that a component takes by itself where the file names none.
doctor::Wanted wanted_by(const InertLaunch& robot) {
  doctor::Wanted wanted = doctor::wanted_by(robot.plan);
  for (const auto& component : robot.inert.loaded) {
    if (!component.declared) continue;
    for (const auto& parameter : component.declared->parameters)
      doctor::want_device(wanted, component.plan->full_name(), parameter.name, parameter.value);
  }
  return wanted;
}

/// What the robots that run on this machine say of themselves.
void ask_containers(Findings& findings) {
  for (const auto& found : trusted_containers()) {
    Finding finding{Severity::Fine, "robot", "", {"container " + found.name, "", ""}};
    auto client = control::Client::connect(found.path);
    const auto ask_for_components = [&]() -> Result<json, Problem> {
      if (!client) return err(client.error());
      ask::Nodes nodes{client.value(), 1s, 1s};
      return ask::list_components(nodes, "");
    };
    const auto reply = ask_for_components();
    if (!reply) {
      finding.severity = Severity::Wrong;
      finding.problem.what = "does not answer: " + reply.error().what;
      finding.problem.way_out = "it may hang in a transition: `nacelle faults`";
      findings.push_back(std::move(finding));
      continue;
    }
    const auto& rows = reply.value()["components"];
    finding.value = std::to_string(rows.size()) + (rows.size() == 1 ? " component runs" : " components run");
    findings.push_back(finding);
    for (const auto& row : rows) {
      if (!row.contains("fault")) continue;
      findings.push_back({Severity::Wrong,
                          "robot",
                          row["fault"]["code"],
                          {found.name + " " + row["node"].get<std::string>(), row["fault"]["text"],
                           "see `nacelle faults` for the time and the handling"}});
    }
  }
}

void print(const Findings& findings) {
  for (const auto& finding : findings)
    print_text("%-7s %-9s %s\n", to_text(finding.severity), finding.about.c_str(), finding.text().c_str());
  print_text("%s\n", doctor::summary(findings).c_str());
}

void print_json(const Findings& findings) {
  json rows = json::array();
  for (const auto& finding : findings) {
    json& row = rows.emplace_back(finding.problem);
    row["severity"] = to_text(finding.severity);
    row["about"] = finding.about;
    row["value"] = finding.value;
  }
  const json all{{"wrong", doctor::is_something_wrong(findings)}, {"findings", std::move(rows)}};
  std::printf("%s\n", all.dump(2).c_str());
}

int examine(const DoctorWish& wish) {
  const auto arguments = parse_or_complain(wish.arguments);
  if (!arguments) return kUsage;
  doctor::Wanted wanted;
  Findings findings;
  if (!wish.file.empty()) {
    auto robot = load_inert_launch(wish.file, *arguments);
    if (robot) {
      wanted = wanted_by(*robot.value());
    } else {
      for (const auto& problem : robot.error()) findings.push_back({Severity::Wrong, "launch", "", problem});
    }
  }
  for (auto& finding : doctor::examine(doctor::Machine{doctor::real_facts(program_version())}, wanted))
    findings.push_back(std::move(finding));
  ask_containers(findings);
  wish.as_json ? print_json(findings) : print(findings);
  return doctor::is_something_wrong(findings) ? kFailed : kDone;
}

}  // namespace

void add_doctor_command(Command& root) {
  auto wish = std::make_shared<DoctorWish>();
  Command& command = root.add("doctor", "check this machine and the robots on it, and suggest fixes");
  command.option("launch_file", wish->file, "also check the devices and permissions that this launch file needs")
      .names_a(Names::File);
  command.option("arguments", wish->arguments, "name:=value for the file's arguments");
  command.flag("--json", wish->as_json, "print one JSON object: wrong, findings");
  command.note(
      "Checks devices, network ports, clock, memory, kernel settings, power, real-time rights, versions, and the\n"
      "running containers. Changes nothing. Needs no root; as root it sees more of other users' programs.\n"
      "Exit codes: 0 nothing is wrong (there may be advice), 1 something is wrong, 2 wrong usage.");
  command.runs([wish] { return examine(*wish); });
  add_doctor_net_command(command);
}

}  // namespace nacelle::cli
