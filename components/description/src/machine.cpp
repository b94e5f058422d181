// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "nacelle/base/files.hpp"

#include "nacelle/description/xacro.hpp"

namespace nacelle::description {
namespace {

void append_folders(const char* variable, std::vector<std::string>& folders) {
  const char* const value = std::getenv(variable);
  std::string_view rest = value == nullptr ? "" : value;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    if (end != 0) folders.emplace_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
}

}  // namespace

XacroEnvironment machine(std::vector<std::string> prefixes) {
  for (const char* const variable : {"NACELLE_PREFIX_PATH", "AMENT_PREFIX_PATH"}) append_folders(variable, prefixes);
  return {[](const std::string& path) { return read_regular_file(path); },
          [prefixes = std::move(prefixes)](const std::string& package) {
            for (const auto& prefix : prefixes) {
              std::error_code fault;
              std::string folder = fmt::format("{}/share/{}", prefix, package);
              if (package.find('/') == std::string::npos && std::filesystem::is_directory(folder, fault)) return folder;
            }
            return std::string{};
          },
          [](const std::string& name) {
            const char* const value = std::getenv(name.c_str());
            return value == nullptr ? std::nullopt : std::optional<std::string>{value};
          }};
}

}  // namespace nacelle::description
