// SPDX-License-Identifier: Apache-2.0
// Other programs on ROS 2's network ports.
#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <sstream>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

/// Port -> inode of the socket. Source: proc_net_udp: "sl local_address rem_address st ... uid timeout inode".
std::multimap<int, std::string> bound_ports(const Machine& machine) {
  std::multimap<int, std::string> ports;
  for (const char* const file : {"/proc/net/udp", "/proc/net/udp6"}) {
    std::istringstream lines{machine.text(file).value_or("")};
    std::string line;
    std::getline(lines, line);  // the heading
    while (std::getline(lines, line)) {
      const auto words = words_of(line);
      const std::size_t colon = words.size() > 9 ? words[1].rfind(':') : std::string::npos;
      if (colon == std::string::npos) continue;
      ports.emplace(static_cast<int>(std::strtol(words[1].c_str() + colon + 1, nullptr, 16)), words[9]);
    }
  }
  return ports;
}

}  // namespace

void check_ports(const Machine& machine, const Wanted&, Findings& findings) {
  // RTPS 2.5, 9.6.1: 7400 + 250 * domain; multicast 0 and 1, then 10 + 2 * participant and the next.
  const int domain = machine.facts().domain, first = 7400 + 250 * domain;
  if (const auto& wrong = machine.facts().wrong_domain) {
    findings.push_back({Severity::Wrong, "ports", "", *wrong});
    return;
  }
  const auto bound = bound_ports(machine);
  std::map<int, std::pair<Process, std::vector<int>>> by_process;
  std::vector<int> unknown;
  for (auto at = bound.lower_bound(first); at != bound.upper_bound(first + 249); ++at) {
    const auto holders = machine.holders("socket:[" + at->second + "]");
    if (holders.empty()) unknown.push_back(at->first);
    for (const auto& process : holders) {
      auto& entry = by_process[process.pid];
      entry.first = process;
      if (entry.second.empty() || entry.second.back() != at->first) entry.second.push_back(at->first);
    }
  }
  const std::string where = fmt::format("UDP {} to {}", first, first + 249);
  const auto listed = [](const std::vector<int>& ports) {
    std::vector<std::string> words;
    for (const int port : ports) words.push_back(std::to_string(port));
    return join(words);
  };
  for (const auto& [pid, entry] : by_process) {
    findings.push_back(
        {Severity::Fine,
         "ports",
         fmt::format("{} of domain {} held by {} (pid {})", listed(entry.second), domain, entry.first.name, pid),
         {where, "", ""}});
  }
  if (!unknown.empty()) {
    findings.push_back(
        {Severity::Fine,
         "ports",
         fmt::format("{} of domain {} held by another user's program (sudo shows which)", listed(unknown), domain),
         {where, "", ""}});
  }
  if (by_process.empty() && unknown.empty())
    findings.push_back({Severity::Fine, "ports", fmt::format("free (domain {})", domain), {where, "", ""}});
}

}  // namespace nacelle::doctor
