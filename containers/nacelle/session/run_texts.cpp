// SPDX-License-Identifier: Apache-2.0
#include "session/run_texts.hpp"

#include <filesystem>
#include <system_error>
#include <utility>

#include "nacelle/launch/parameter_value.hpp"

namespace nacelle::session {
namespace {

constexpr const char* kYaml = "application/yaml";

std::filesystem::path whole(const std::string& path) {
  std::error_code error;
  const auto made = std::filesystem::absolute(path, error);
  return error ? std::filesystem::path{path} : made.lexically_normal();
}

}  // namespace

RunText parameters_text(const runtime::Container& container) {
  std::string text;
  for (const auto& info : container.list()) {
    std::string values;
    const auto add = [&](const std::string& name, const ParameterValue& value) {
      if (type_of(value) != ParameterType::NotSet) values += "    " + name + ": " + launch::to_text(value) + "\n";
    };
    if (const auto reports = container.parameters_of(info.id)) {
      for (const auto& report : *reports) add(report.name, report.value);
    } else if (const auto request = container.request_of(info.id)) {
      for (const auto& [name, value] : request->parameters) add(name, value);
    }
    text += info.node + ":\n  ros__parameters:\n" + (values.empty() ? "    {}\n" : values);
  }
  return {"parameters.yaml", kYaml, std::move(text)};
}

RunText file_text(const std::string& main, const std::string& path, std::string text) {
  const auto near = whole(path).lexically_relative(whole(main).parent_path());
  const bool is_below = !near.empty() && *near.begin() != "..";
  const bool is_xml = path.ends_with(".xml") || path.ends_with(".urdf") || path.ends_with(".xacro");
  return {is_below ? near.string() : path, is_xml ? "application/xml" : kYaml, std::move(text)};
}

}  // namespace nacelle::session
