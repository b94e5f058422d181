// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/load_plan.hpp"

#include <cstdlib>
#include <filesystem>

#include "builder.hpp"
#include "nacelle/base/files.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::launch {

Environment system_environment() {
  Environment environment;
  environment.getenv = [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  };
  environment.find_package_share = [](const std::string& /*package*/) { return std::optional<std::string>(); };
  environment.read_file = [](const std::string& path) { return read_regular_file(path, kMaxYamlBytes); };
  std::error_code gone;  // a working directory that was deleted has no name: paths stay as they are
  environment.working_directory = std::filesystem::current_path(gone).string();
  return environment;
}

namespace {

Result<Plan, std::vector<Problem>> build(const std::string& text, const std::string& file,
                                         const std::map<std::string, std::string>& arguments,
                                         const Environment& environment, Wanted wanted) {
  Builder builder(environment, arguments, wanted);
  if (arguments.contains(kNamespaceArgument) || arguments.contains(kTfArgument)) {
    Builder survey(environment, arguments, Wanted::Arguments);
    survey.run_top(text, file);
    builder.take_namespace_arguments(survey.declared_arguments());
  }
  builder.run_top(text, file);
  return builder.finish();
}

Result<Plan, std::vector<Problem>> read(const std::string& file, const std::map<std::string, std::string>& arguments,
                                        const Environment& environment, Wanted wanted) {
  if (!environment.read_file)
    return err(std::vector<Problem>{{file, "the launch file cannot be read", "", LaunchFault::Unreadable}});
  const auto text = environment.read_file(file);
  if (!text)
    return err(std::vector<Problem>{
        {file, "the launch file " + text.error().what, text.error().way_out, LaunchFault::Unreadable}});
  return build(*text, file, arguments, environment, wanted);
}

}  // namespace

Result<Plan, std::vector<Problem>> load_plan_text(const std::string& text, const std::string& file,
                                                  const std::map<std::string, std::string>& arguments,
                                                  const Environment& environment) {
  return build(text, file, arguments, environment, Wanted::Plan);
}

Result<Plan, std::vector<Problem>> load_plan(const std::string& file,
                                             const std::map<std::string, std::string>& arguments,
                                             const Environment& environment) {
  return read(file, arguments, environment, Wanted::Plan);
}

Result<Plan, std::vector<Problem>> load_arguments(const std::string& file,
                                                  const std::map<std::string, std::string>& arguments,
                                                  const Environment& environment) {
  return read(file, arguments, environment, Wanted::Arguments);
}

Result<std::map<std::string, std::string>, std::vector<Problem>> parse_arguments(
    const std::vector<std::string>& words) {
  std::map<std::string, std::string> arguments;
  std::vector<Problem> problems;
  for (const auto& word : words) {
    const auto split = word.find(":=");
    if (split == std::string::npos || split == 0) {
      problems.push_back({"", "the launch argument '" + word.substr(0, 80) + "' is not name:=value", ""});
    } else {
      arguments[word.substr(0, split)] = word.substr(split + 2);
    }
  }
  if (!problems.empty()) return err(std::move(problems));
  return arguments;
}

}  // namespace nacelle::launch
