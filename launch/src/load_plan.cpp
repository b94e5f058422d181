// SPDX-License-Identifier: Apache-2.0
#include "nacelle/launch/load_plan.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "builder.hpp"
#include "nacelle/qos/yaml_tree.hpp"

namespace nacelle::launch {
namespace {

std::optional<std::string> read_system_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  // One byte more than is allowed, so that the parser can say what is wrong with a larger one.
  std::string text(kMaxYamlBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return std::nullopt;
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace

Environment system_environment() {
  Environment environment;
  environment.getenv = [](const std::string& name) -> std::optional<std::string> {
    const char* value = std::getenv(name.c_str());
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  };
  environment.find_package_share = [](const std::string& /*package*/) { return std::optional<std::string>(); };
  environment.read_file = read_system_file;
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
  const auto text = environment.read_file ? environment.read_file(file) : std::nullopt;
  if (!text)
    return err(
        std::vector<Problem>{{file, "the launch file cannot be read", "is it there, and may this user read it?"}});
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
