// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdlib>
#include <sstream>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

/// The soft limit of a line of /proc/self/limits: "Max realtime priority     0     0". Nothing: unlimited, or not there.
std::optional<std::int64_t> soft_limit(const Machine& machine, const std::string& name) {
  std::istringstream lines{machine.text("/proc/self/limits").value_or("")};
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind(name, 0) == 0) return leading_number(std::string_view{line}.substr(name.size()));
  }
  return std::nullopt;
}

constexpr unsigned kCapSysNice = 23;  // linux/capability.h

bool has_sys_nice(const Machine& machine) {
  const auto effective = machine.field("/proc/self/status", "CapEff");
  return effective && (std::strtoull(effective->c_str(), nullptr, 16) >> kCapSysNice & 1U) != 0;
}

constexpr const char* kWayOut =
    "put '@robot - rtprio 95' and '@robot - memlock unlimited' into /etc/security/limits.d/robot.conf and this user "
    "into the "
    "group robot, or LimitRTPRIO=95 into the service; then log in again";

}  // namespace

void check_realtime(const Machine& machine, const Wanted& wanted, Findings& findings) {
  const auto most = soft_limit(machine, "Max realtime priority");
  const bool may_all = has_sys_nice(machine);
  const auto allowed = may_all ? 99 : most.value_or(99);
  const std::string value = may_all ? "any (CAP_SYS_NICE)" : fmt::format("up to {}", allowed);
  Finding rights{Severity::Fine, "realtime", value, {"real-time priority", "", ""}};
  if (allowed == 0) {
    rights.severity = Severity::Advice;
    rights.value = "none";
    rights.problem.what = "threads of the launch file with a priority run without it";
    rights.problem.way_out = kWayOut;
  }
  for (const auto& thread : wanted.priorities) {
    if (thread.priority <= allowed) continue;
    rights.severity = Severity::Wrong;
    rights.problem.what = fmt::format("{} asks for {}", thread.by, thread.priority);
    rights.problem.way_out = kWayOut;
  }
  findings.push_back(std::move(rights));

  const auto locked = soft_limit(machine, "Max locked memory");
  Finding memory{Severity::Fine,
                 "realtime",
                 locked ? fmt::format("{:.1f} MB", static_cast<double>(*locked) / 1e6) : "unlimited",
                 {"lockable memory", "", ""}};
  if (locked && *locked < 64LL * 1000 * 1000 && !wanted.priorities.empty() && !machine.is_root()) {
    memory.severity = Severity::Advice;
    memory.problem.what = "pages of real-time threads may have to be read back";
    memory.problem.way_out = kWayOut;
  }
  findings.push_back(std::move(memory));
}

}  // namespace nacelle::doctor
