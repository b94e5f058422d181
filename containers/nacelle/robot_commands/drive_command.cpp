// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "cli/program.hpp"
#include "cli/version.hpp"
#include "drive/drive.hpp"
#include "nacelle/launch/load_plan.hpp"
#include "process/foreign_programs.hpp"
#include "robot_commands/commands.hpp"

namespace nacelle::cli {
namespace {

struct DriveWish {
  std::vector<std::string> words;  // perhaps a file, then name:=value
  double seconds = -1;             // not given
  bool twist = false;
  drive::DriveSettings settings;
};

/// Returns the rates that the launch file's monitors expect, by topic.
std::map<std::string, double> expected_rates(const launch::Plan& plan) {
  std::map<std::string, double> rates;
  for (const auto& component : plan.components) {
    const auto value_of = [&](const char* name) {
      const auto found = std::ranges::find(component.parameters, name, &launch::Parameter::name);
      return found == component.parameters.end() ? nullptr : &found->value;
    };
    const auto* const names = value_of("streams");
    const auto* const values = value_of("expected_rates");
    if (component.plugin != "nacelle::monitor::MonitorComponent" || names == nullptr || values == nullptr) continue;
    const auto* const topics = std::get_if<std::vector<std::string>>(names);
    const auto* const hz = std::get_if<std::vector<double>>(values);
    if (topics == nullptr || hz == nullptr) continue;
    for (std::size_t i = 0; i < std::min(topics->size(), hz->size()); ++i) {
      if ((*hz)[i] > 0.0) rates[plan.name_space.topic((*topics)[i])] = (*hz)[i];
    }
  }
  return rates;
}

/// Takes the names from the launch file. The container reports a file that cannot be read.
void take_names(drive::DriveSettings& settings) {
  std::vector<std::string> words{"sim:=true"};
  words.insert(words.end(), settings.arguments.begin(), settings.arguments.end());
  const auto arguments = launch::parse_arguments(words);
  if (!arguments) return;
  const auto plan = launch::load_plan(settings.launch_file, arguments.value(), launch_environment(program_places()));
  if (!plan) return;
  const launch::NamespacePlan& names = plan.value().name_space;
  for (std::string* const topic : {&settings.topic, &settings.odometry_topic}) *topic = names.topic(topic->substr(1));
  for (std::string* const frame : {&settings.odom_frame, &settings.base_frame, &settings.command_frame})
    *frame = names.frame(*frame);
  settings.robot = plan.value().container.name + (names.moves() ? " in " + names.path : "");
  settings.nominal_hz = expected_rates(plan.value());
}

int run(DriveWish& wish) {
  process::StopSignal stop{process::kill_all_programs};
  for (const auto& word : wish.words) {
    if (word.find(":=") != std::string::npos) {
      wish.settings.arguments.push_back(word);
    } else if (wish.settings.launch_file.empty()) {
      wish.settings.launch_file = word;
    } else {
      complain({"'" + word + "'", "one launch file is enough", "arguments are written name:=value"});
      return kUsage;
    }
  }
  if (wish.settings.launch_file.empty()) wish.settings.launch_file = default_launch_file();
  if (wish.settings.launch_file.empty())
    return complain({"drive", "the default launch file does not exist", "name one: nacelle drive FILE"});
  wish.settings.program = program_places().program;
  wish.settings.stamped = !wish.twist;
  wish.settings.version = program_version();
  take_names(wish.settings);
  const SystemClock clock;
  return drive::run_drive(wish.settings, stop, clock);
}

}  // namespace

void add_drive_command(Command& root) {
  auto wish = std::make_shared<DriveWish>();
  Command& command = root.add("drive", "drive the simulated robot round a one-metre square and print its figures");
  command.option("words", wish->words, "a launch file (default: the robot's), and name:=value for its arguments")
      .names_a(Names::File);
  command.flag("--stay", wish->settings.stay, "run without driving until Ctrl-C");
  command.option("--for", wish->seconds, "run this many seconds without driving")
      .value("SECONDS")
      .within(0, 1e6)
      .not_with("--stay");
  command.option("--seed", wish->settings.seed, "seed of the world's random numbers")
      .checked([](const std::string& text) {
        // CLI11's own check would print the largest double.
        return text.rfind('-', 0) == 0 ? "must be 0 or more, not " + text : std::string{};
      })
      .with_default();
  command.option("--report", wish->settings.report_file, "write the figures to this JSON file").names_a(Names::File);
  command.option("--report-html", wish->settings.html_file, "write a page with pictures of the run to this HTML file")
      .names_a(Names::File);
  command.option("--speed", wish->settings.course.speed_mps, "top speed in m/s").within(0.02, 0.3).with_default();
  command.flag("--twist", wish->twist, "send Twist instead of TwistStamped");
  command.flag("-v,--verbose", wish->settings.verbose, "show the container's log lines");
  command.note(
      "The robot stays off ROS 2's network, where it could drive other robots, unless you give network:=local or "
      "export.");
  command.note("Ctrl-C ends it. In the background (nacelle drive --stay &), use: kill %1, or kill PID.");
  command.runs([wish] {
    if (wish->seconds >= 0) wish->settings.duration = from_seconds(wish->seconds);
    return run(*wish);
  });
}

}  // namespace nacelle::cli
