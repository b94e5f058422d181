// SPDX-License-Identifier: Apache-2.0
#include "cli/inert_launch.hpp"

#include "nacelle/base/log.hpp"

namespace nacelle::cli {

std::optional<std::map<std::string, std::string>> parse_or_complain(const std::vector<std::string>& words) {
  auto arguments = launch::parse_arguments(words);
  if (arguments) return std::move(arguments).value();
  for (const auto& problem : arguments.error()) complain(problem);
  return std::nullopt;
}

Result<std::unique_ptr<InertLaunch>, std::vector<Problem>> load_inert_launch(
    const std::string& file, const std::map<std::string, std::string>& arguments) {
  // The findings report the components' remarks during construction, with file and line.
  set_log_level(LogLevel::Error);
  auto robot = std::make_unique<InertLaunch>();
  robot->places = program_places();
  auto plan = launch::load_plan(file, arguments, launch_environment(robot->places));
  if (!plan) return err(plan.error());
  robot->plan = std::move(plan).value();
  robot->inert = proof::make_inert(robot->plan, robot->places, robot->clock);
  return robot;
}

Result<std::unique_ptr<InertLaunch>, int> open_inert_launch(const std::string& file,
                                                            const std::vector<std::string>& words) {
  const auto arguments = parse_or_complain(words);
  if (!arguments) return err(kUsage);
  auto loaded = load_inert_launch(file, *arguments);
  if (loaded) return std::move(loaded).value();
  for (const auto& problem : loaded.error()) complain(problem);
  return err(kFailed);
}

std::size_t stream_count(const runtime::Container& container) {
  std::vector<runtime::StreamReport> streams;
  container.report_streams(streams);
  return streams.size();
}

}  // namespace nacelle::cli
