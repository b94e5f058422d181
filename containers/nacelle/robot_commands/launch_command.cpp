// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/log.hpp"
#include "process/service_manager.hpp"
#include "process/stop_signal.hpp"
#include "robot_commands/commands.hpp"
#include "session/run_texts.hpp"
#include "session/session.hpp"

namespace nacelle::cli {
namespace {

struct LaunchWish {
  std::string file;
  std::vector<std::string> arguments;
  std::string name, report_file, carrier, state_file, transitions_file, test_clock;
  std::vector<std::string> last_messages;
  long parent_pid = 0;
  bool verbose = false, show_arguments = false, resume = false;
};

/// The world's seed is an argument of the launch file; only the report asks.
std::optional<std::int64_t> seed_of(const launch::Plan& plan, const std::map<std::string, std::string>& arguments) {
  std::string text;
  for (const auto& argument : plan.arguments) {
    if (argument.name == "seed") text = argument.default_value.value_or("");
  }
  if (const auto given = arguments.find("seed"); given != arguments.end()) text = given->second;
  std::int64_t seed = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (text.empty() || read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
  return seed;
}

void show_arguments(const launch::Plan& plan) {
  std::printf("Arguments (pass arguments as '<name>:=<value>'):\n");
  for (const auto& argument : plan.arguments) {
    print_text("\n    '%s':\n", argument.name.c_str());
    if (!argument.description.empty()) print_text("        %s\n", argument.description.c_str());
    if (argument.default_value) {
      print_text("        (default: '%s')\n", argument.default_value->c_str());
    } else {
      std::printf("        (required)\n");
    }
  }
  struct ForEveryFile {
    const char *name, *description, *without;
  };
  static constexpr ForEveryFile kArguments[] = {
      {"namespace", "namespace of all nodes; every launch file has this argument", "what the launch file says"},
      {"tf", "topics: /tf moves into the namespace; frames: frame names get it as a prefix", "topics"},
      {"network", "who can see the robot: off, local or export; every launch file has this argument",
       "what the launch file and ROS 2's variables say"}};
  for (const auto& [name, description, without] : kArguments) {
    if (std::ranges::find(plan.arguments, name, &launch::ArgumentPlan::name) != plan.arguments.end()) continue;
    print_text("\n    '%s':\n        %s\n        (default: %s)\n", name, description, without);
  }
}

int run(const LaunchWish& wish) {
  if (auto enough = session::Session::check_descriptor_limit(); !enough) return complain(enough.error());
  // First of all, because there are no other threads yet.
  const auto manager = process::ServiceManager::take_from_environment();
  // From here on no signal ends the process half way.
  process::StopSignal stop{session::leave_at_once, process::FullOutput::Kept, process::hangup_with(manager)};
  die_with_parent(wish.parent_pid);
  auto arguments = launch::parse_arguments(wish.arguments);
  if (!arguments) {
    for (const auto& problem : arguments.error()) complain(problem);
    return kUsage;
  }
  const loading::ProgramPlaces places = program_places();
  std::vector<RunText> files;
  launch::Environment environment = launch_environment(places);
  environment.read_file = [&, read = environment.read_file](const std::string& path) {
    auto text = read(path);
    if (!text) return text;
    RunText file = session::file_text(wish.file, path, *text);
    if (std::ranges::find(files, file.name, &RunText::name) == files.end()) files.push_back(std::move(file));
    return text;
  };
  auto plan = wish.show_arguments ? launch::load_arguments(wish.file, arguments.value(), environment)
                                  : launch::load_plan(wish.file, arguments.value(), environment);
  if (!plan) {
    for (const auto& problem : plan.error()) complain(problem);
    return kFailed;
  }
  if (wish.show_arguments) {
    show_arguments(plan.value());
    return kDone;
  }
  if (plan.value().components.empty() && plan.value().programs.empty() && !plan.value().container.declared) {
    return complain({wish.file, "there is nothing to start",
                     "it needs a node_container with composable_node, a node or an executable (is an `if` false?)"});
  }
  if (!wish.report_file.empty()) {
    if (auto fine = report::check_report_file(wish.report_file); !fine) return complain(fine.error());
  }
  session::SessionOptions options;
  options.container_name = wish.name.empty() ? plan.value().container.name : wish.name;
  options.places = places;
  options.files = std::move(files);
  options.seed = seed_of(plan.value(), arguments.value());
  options.report_file = wish.report_file;
  options.last_messages = wish.last_messages;
  options.verbose = wish.verbose;
  options.carrier = wish.carrier;
  options.transitions_file = wish.transitions_file;
  options.state_file = wish.state_file;
  options.resume = wish.resume;
  options.service_manager = &manager;
  options.reread = [file = wish.file, given = arguments.value(), places] {
    return launch::load_plan(file, given, launch_environment(places));
  };
  const SystemClock system_clock;
  std::unique_ptr<session::TestClock> test_clock;
  if (!wish.test_clock.empty()) {
    auto opened = session::TestClock::open(wish.test_clock);
    if (!opened) return complain(opened.error());
    test_clock = std::move(opened).value();
    options.clock_alarm = test_clock.get();
  }
  const Clock& clock = test_clock ? static_cast<const Clock&>(*test_clock) : system_clock;
  session::Session session{std::move(plan).value(), std::move(options), clock, stop};
  return session.run();
}

}  // namespace

void add_launch_command(Command& root) {
  auto wish = std::make_shared<LaunchWish>();
  Command& command = root.add("launch", "start the components of a launch file and run them until Ctrl-C");
  command.option("file", wish->file, "a .launch.yaml, .launch.xml file").required().names_a(Names::File);
  command.option("arguments", wish->arguments, "name:=value for the file's arguments");
  command.option("--name", wish->name, "the container's name on its control socket (default: the file's)")
      .checked(wrong_container_name);
  command.option("--report", wish->report_file, "write figures of the run to this JSON file").names_a(Names::File);
  command.option("--carrier", wish->carrier, "transport for the streams of components with `isolate: process`: iceoryx")
      .one_of({"iceoryx"});
  command
      .option("--transitions", wish->transitions_file,
              "write each component's steps to this file in the plan's order, and their times to FILE.times")
      .names_a(Names::File);
  command.flag("-s,--show-args", wish->show_arguments, "show the file's arguments and start nothing");
  command.flag("--resume", wish->resume,
               "after a crash, restore the components, parameters and states of the last run instead of the file's");
  command
      .option("--state", wish->state_file, "where to keep the state for --resume (default: beside the control socket)")
      .names_a(Names::File);
  command.flag("-v,--verbose", wish->verbose, "print a line for each step");
  command.option("--last-message", wish->last_messages, "add the topic's last message to the report").hidden();
  command.option("--test-clock", wish->test_clock, "a FIFO that sets the wall clock of this process, for tests")
      .hidden();
  command.option("--parent", wish->parent_pid, "end when this process ends").hidden();
  command.note(
      "Ctrl-C ends it. In the background (nacelle launch FILE &), use: kill %1, or kill PID.\n"
      "All keys of a launch file: docs/launch_files.md in the source tree.");
  command.runs([wish] { return run(*wish); });
}

}  // namespace nacelle::cli
