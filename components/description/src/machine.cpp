// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "nacelle/description/xacro.hpp"

namespace nacelle::description {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{16} << 20;

Result<std::string, Problem> read_whole(const std::string& path) {
  std::error_code fault;
  if (std::filesystem::is_directory(path, fault)) return err(Problem{path, "is a folder", "give a file"});
  std::ifstream file(path, std::ios::binary);
  if (!file) return err(Problem{path, "cannot be read", "is it there, and may this user read it?"});
  std::string text;
  for (char block[65536]; file.read(block, sizeof block) || file.gcount() > 0;) {
    text.append(block, static_cast<std::size_t>(file.gcount()));
    if (text.size() > kMaxFileBytes)
      return err(Problem{path, "is larger than 16 MiB, which no robot description is", ""});
  }
  return text;
}

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
  return {read_whole,
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
