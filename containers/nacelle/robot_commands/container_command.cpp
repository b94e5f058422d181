// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>

#include "cli/program.hpp"
#include "process/service_manager.hpp"
#include "process/stop_signal.hpp"
#include "robot_commands/commands.hpp"
#include "session/session.hpp"

namespace nacelle::cli {
namespace {

struct ContainerWish {
  std::string name = "nacelle", state_file;
  std::vector<std::string> arguments;
  bool resume = false, verbose = false;
};

/// There is no launch file, so there is one argument.
Result<void, Problem> take_arguments(const std::vector<std::string>& words, launch::NetworkPlan& network) {
  const auto arguments = launch::parse_arguments(words);
  if (!arguments) return err(arguments.error().front());
  for (const auto& [name, value] : *arguments) {
    if (name != "network")
      return err(Problem{fmt::format("'{}:={}'", name, value), "the container takes network:=MODE only",
                         suggestion(name, {"network"})});
    const auto mode = launch::parse_network_argument(value);
    if (!mode) return err(mode.error());
    network.mode = mode.value();
    network.mode_by_argument = true;
  }
  return {};
}

int run(const ContainerWish& wish) {
  if (auto enough = session::Session::check_descriptor_limit(); !enough) return complain(enough.error());
  const auto manager = process::ServiceManager::take_from_environment();
  process::StopSignal stop{session::leave_at_once, process::FullOutput::Kept, process::hangup_with(manager)};
  launch::Plan plan;
  if (const auto taken = take_arguments(wish.arguments, plan.network); !taken) return complain_of_usage(taken.error());
  plan.file = "nacelle container";
  plan.container.name = wish.name;
  plan.container.declared = true;
  plan.container.where = {plan.file, 0};
  session::SessionOptions options;
  options.container_name = wish.name;
  options.places = program_places();
  options.verbose = wish.verbose;
  options.state_file = wish.state_file;
  options.resume = wish.resume;
  options.service_manager = &manager;
  const SystemClock clock;
  session::Session session{std::move(plan), std::move(options), clock, stop};
  return session.run();
}

}  // namespace

void add_container_command(Command& root) {
  auto wish = std::make_shared<ContainerWish>();
  Command& command =
      root.add("container", "run an empty container until Ctrl-C; load components with `nacelle component load`");
  command.option("arguments", wish->arguments, "network:=off, local or export: who can see the robot");
  command.option("--name", wish->name, "its name on the control socket").with_default().checked(wrong_container_name);
  command.flag("--resume", wish->resume,
               "after a crash, restore the components, parameters and states of the last run");
  command
      .option("--state", wish->state_file, "where to keep the state for --resume (default: beside the control socket)")
      .names_a(Names::File);
  command.flag("-v,--verbose", wish->verbose, "print a line for each step");
  command.note(
      "Ctrl-C ends it. In the background (nacelle container &), use: kill %1, or kill PID.\n"
      "What survives a crash, and how: docs/supervision.md in the source tree.");
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
