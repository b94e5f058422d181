// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli/inert_launch.hpp"
#include "cli/output.hpp"
#include "cli/program.hpp"
#include "drawing/graphviz.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/launch/parameter_value.hpp"
#include "offline_commands/commands.hpp"
#include "proof/drawing.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;

struct CheckWish {
  std::string node, file, graph;
  std::vector<std::string> arguments;
  bool as_json = false;
};

json to_json(const proof::Finding& finding) {
  json row = finding.problem;
  row["severity"] = proof::to_text(finding.severity);
  row["about"] = finding.about();
  return row;
}

int answer(const CheckWish& wish, const std::vector<proof::Finding>& findings, std::size_t components,
           std::size_t streams) {
  const bool failed = proof::has_errors(findings);
  if (wish.as_json) {
    json rows = json::array();
    for (const auto& finding : findings) rows.push_back(to_json(finding));
    const char* const verdict = failed ? "error" : findings.empty() ? "ok" : "warning";
    const json all{
        {"verdict", verdict}, {"components", components}, {"streams", streams}, {"findings", std::move(rows)}};
    std::printf("%s\n", all.dump(2).c_str());
  } else {
    for (const auto& finding : findings) print_text("%s\n", finding.text().c_str());
    print_text("%s: %zu component%s, %zu stream%s: %s\n", wish.file.c_str(), components, components == 1 ? "" : "s",
               streams, streams == 1 ? "" : "s", proof::summary(findings).c_str());
  }
  return failed ? kFailed : kDone;
}

/// Red are the ends of pairs that cannot talk.
Result<void, Problem> write_graph(const std::string& path, runtime::Container& container) {
  std::vector<std::string> bad;
  for (const auto& clash : container.clashes()) {
    bad.push_back(clash.topic + " " + clash.writer_node);
    bad.push_back(clash.topic + " " + clash.reader_node);
  }
  auto told = drawing::write_drawing(path, proof::to_dot(proof::endpoints_of(container.graph()), bad));
  if (!told) return err(told.error());
  if (!told.value().empty()) std::fprintf(stderr, "nacelle: %s\n", told.value().c_str());
  return {};
}

int check_launch_file(const CheckWish& wish) {
  if (!wish.graph.empty() && !drawing::drawing_format(wish.graph)) {
    complain({"--graph " + wish.graph, "is no .svg, .pdf, .png or .dot file", "name it so, e.g. robot.svg"});
    return kUsage;
  }
  const auto arguments = parse_or_complain(wish.arguments);
  if (!arguments) return kUsage;
  auto loaded = load_inert_launch(wish.file, *arguments);
  if (!loaded) return answer(wish, proof::findings_of(loaded.error()), 0, 0);
  const InertLaunch& robot = *loaded.value();
  auto findings = proof::prove(robot.plan, robot.places, *robot.inert.container, robot.inert.loaded);
  findings.insert(findings.end(), robot.inert.findings.begin(), robot.inert.findings.end());
  if (!wish.graph.empty()) {
    if (auto drawn = write_graph(wish.graph, *robot.inert.container); !drawn) return complain(drawn.error());
  }
  return answer(wish, findings, robot.plan.components.size(), stream_count(*robot.inert.container));
}

// --- params -------------------------------------------------------------------------------------------------------------

struct Row {
  std::string name, value, type, origin;
};

std::vector<Row> rows_of(const proof::LoadedComponent& component) {
  std::vector<Row> rows;
  for (const auto& parameter : component.declared->parameters) {
    Row row{parameter.name, launch::to_text(parameter.value), launch::type_name(parameter.value), "default"};
    for (const auto& given : component.plan->parameters) {
      if (given.name == parameter.name) row.origin = given.where.text();
    }
    if (component.has_fault_of(parameter.name)) row.origin = "default; the value of " + row.origin + " is refused";
    rows.push_back(std::move(row));
  }
  return rows;
}

int explain_parameters(const CheckWish& wish) {
  const auto loaded = open_inert_launch(wish.file, wish.arguments);
  if (!loaded) return loaded.error();
  const InertLaunch& robot = *loaded.value();
  const proof::LoadedComponent* found = nullptr;
  std::vector<std::string> names;
  for (const auto& component : robot.inert.loaded) {
    names.push_back(component.plan->full_name());
    if (component.plan->full_name() == wish.node || component.plan->name == wish.node) found = &component;
  }
  if (found == nullptr) return complain({"node " + wish.node, "is not in " + wish.file, suggestion(wish.node, names)});
  if (found->failure)
    return complain(
        {found->plan->where, found->failure->where.text() + ": " + found->failure->what, found->failure->way_out});
  const std::vector<Row> rows = rows_of(*found);
  if (wish.as_json) {
    json all = json::array();
    for (const auto& row : rows)
      all.push_back({{"name", row.name}, {"value", row.value}, {"type", row.type}, {"origin", row.origin}});
    std::printf("%s\n", json{{"node", found->plan->full_name()}, {"parameters", std::move(all)}}.dump(2).c_str());
  } else {
    std::size_t widest = 0;
    for (const auto& row : rows) widest = std::max(widest, row.name.size() + row.value.size() + 2);
    widest = std::min<std::size_t>(widest, 60);
    for (const auto& row : rows) {
      const std::string pair = row.name + ": " + (row.value.empty() ? "(not set)" : row.value);
      print_text("%-*s  # %s\n", static_cast<int>(widest), pair.c_str(), row.origin.c_str());
    }
  }
  // Values for unknown parameters are not in the list, but are often what the user is looking for.
  for (const auto& name : found->declared->unknown_parameters) {
    if (name == "frame_prefix" && !robot.plan.name_space.frame_prefix().empty())
      continue;  // all nodes of the launch are given it
    complain({proof::place_of_parameter(*found->plan, name),
              found->plan->full_name() + " has no parameter '" + name + "'", "see `nacelle check`"});
  }
  return kDone;
}

}  // namespace

void add_check_commands(Command& root) {
  const auto wish = std::make_shared<CheckWish>();
  Command& check = root.add("check", "check a launch file before anything moves");
  check.option("launch_file", wish->file, "a .launch.yaml or .launch.xml file").required().names_a(Names::File);
  check.option("arguments", wish->arguments, "name:=value for the file's arguments");
  check.flag("--json", wish->as_json, "print one JSON object: verdict, findings");
  check
      .option("--graph", wish->graph,
              "draw the pipeline with the QoS of each endpoint to FILE.svg, .pdf, .png (by Graphviz) or .dot")
      .names_a(Names::File);
  check.note(
      "Constructs every component, which touches no hardware, and checks types, quality of service, parameters,\n"
      "frames, order, remaps, libraries, programs and budgets. `nacelle launch` runs the same checks first.\n"
      "Exit codes: 0 no error (there may be warnings), 1 an error was found, 2 wrong usage.");
  check.runs([wish] { return check_launch_file(*wish); });

  Command& params = root.add("params", "show where the parameters of a launch file come from");
  params.option("--explain", wish->node, "show the parameters of this node, each with its file and line").required();
  params.option("launch_file", wish->file, "a .launch.yaml or .launch.xml file").required().names_a(Names::File);
  params.option("arguments", wish->arguments, "name:=value for the file's arguments");
  params.flag("--json", wish->as_json, "print one JSON object: node, parameters");
  params.note("Exit codes: 0 success, 1 no such node or file, 2 wrong usage.");
  params.runs([wish] { return explain_parameters(*wish); });
}

}  // namespace nacelle::cli
