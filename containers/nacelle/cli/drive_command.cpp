// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>

#include "commands.hpp"
#include "nacelle/drive/drive.hpp"
#include "nacelle/session/foreign_programs.hpp"
#include "program.hpp"

namespace nacelle::cli {
namespace {

struct Wish {
  std::vector<std::string> words;  // perhaps a file, then name:=value
  double seconds = 0;
  bool twist = false;
  drive::DriveSettings settings;
};

int run(Wish& wish) {
  session::StopSignal stop{session::kill_all_programs};
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
    return complain({"drive", "the default launch file is not there", "name one: nacelle drive FILE"});
  wish.settings.program = program_places().program;
  wish.settings.stamped = !wish.twist;
  const SystemClock clock;
  return drive::run_drive(wish.settings, stop, clock);
}

}  // namespace

void add_drive_command(CLI::App& app, int& exit_code) {
  auto wish = std::make_shared<Wish>();
  CLI::App* const command =
      app.add_subcommand("drive", "drive the simulated robot round a one-metre square and show the figures");
  command->add_option("words", wish->words, "a launch file (default: the robot's), and name:=value for its arguments");
  CLI::Option* const duration = command->add_option("--for", wish->seconds, "run this many seconds without driving")
                                    ->type_name("SECONDS")
                                    ->check(CLI::Range(0.0, 1e6));
  CLI::Option* const stay = command->add_flag("--stay", wish->settings.stay, "run without driving until Ctrl-C");
  duration->excludes(stay);
  command->add_option("--seed", wish->settings.seed, "the world's random numbers")
      ->check(CLI::Validator{[](const std::string& text) {
                               // CLI11's own check would print the largest double.
                               return text.rfind('-', 0) == 0 ? "must be 0 or more, not " + text : std::string{};
                             },
                             ""})
      ->capture_default_str();
  command->add_option("--report", wish->settings.report_file, "write the figures to this JSON file");
  command->add_option("--speed", wish->settings.course.speed_mps, "top speed in m/s")
      ->check(CLI::Range(0.02, 0.3))
      ->capture_default_str();
  command->add_flag("--twist", wish->twist, "send Twist instead of TwistStamped");
  command->add_flag("-v,--verbose", wish->settings.verbose, "show the container's own lines");
  command->callback([wish, duration, &exit_code] {
    if (duration->count() > 0) wish->settings.duration = from_seconds(wish->seconds);
    exit_code = run(*wish);
  });
}

}  // namespace nacelle::cli
