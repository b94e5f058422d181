// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <set>
#include <sstream>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

/// The libraries that a process has mapped, by file name; the version stands in it: "libfmt.so.9.1.0".
std::set<std::string> libraries(const Machine& machine) {
  std::set<std::string> names;
  std::istringstream lines{machine.text("/proc/self/maps").value_or("")};
  for (std::string line; std::getline(lines, line);) {
    const std::size_t slash = line.rfind('/');
    if (slash == std::string::npos) continue;
    const std::string name = line.substr(slash + 1);
    if (name.find(".so") != std::string::npos) names.insert(machine.resolved(line.substr(line.find('/'))));
  }
  return names;
}

}  // namespace

void check_versions(const Machine& machine, const Wanted&, Findings& findings) {
  const auto say = [&](const char* where, std::string value) {
    findings.push_back({Severity::Fine, "versions", std::move(value), {where, "", ""}});
  };
  say("nacelle", machine.facts().version);
  std::string system = "?";
  std::istringstream lines{machine.text("/etc/os-release").value_or("")};
  for (std::string line; std::getline(lines, line);) {
    constexpr std::string_view kKey = "PRETTY_NAME=\"";
    if (line.rfind(kKey, 0) == 0) system = line.substr(kKey.size(), line.rfind('"') - kKey.size());
  }
  if (const auto model = machine.text("/proc/device-tree/model")) system += " on " + std::string{model->c_str()};
  say("system", fmt::format("{}, Linux {}", system, machine.text("/proc/sys/kernel/osrelease").value_or("?")));
  std::string all;
  for (const auto& path : libraries(machine)) {
    const std::string name = path.substr(path.rfind('/') + 1);
    if (name.rfind("libnacelle", 0) == 0) continue;
    all += (all.empty() ? "" : " ") + name;
  }
  if (!all.empty()) say("libraries", all);
}

}  // namespace nacelle::doctor
