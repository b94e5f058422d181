// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <sstream>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

constexpr const char* kMemory = "memory";
constexpr double kMega = 1e6;

std::optional<double> meminfo_mb(const Machine& machine, const char* key) {
  const auto field = machine.field("/proc/meminfo", key);
  const auto kibibytes = field ? leading_number(*field) : std::nullopt;
  if (!kibibytes) return std::nullopt;
  return static_cast<double>(*kibibytes) * 1024 / kMega;
}

/// Of the unified hierarchy: "0::/system.slice/robot.service".
std::string cgroup_folder(const Machine& machine) {
  std::istringstream lines{machine.text("/proc/self/cgroup").value_or("")};
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("0::", 0) == 0) return "/sys/fs/cgroup" + (line.substr(3) == "/" ? "" : line.substr(3));
  }
  return {};
}

void check_cgroup(const Machine& machine, Findings& findings) {
  const std::string folder = cgroup_folder(machine);
  if (folder.empty()) return;
  if (const auto most = machine.number(folder + "/memory.max")) {  // "max" is no number: no limit
    const double most_mb = static_cast<double>(*most) / kMega;
    const double used_mb = static_cast<double>(machine.number(folder + "/memory.current").value_or(0)) / kMega;
    Finding finding{Severity::Fine,
                    kMemory,
                    fmt::format("{:.0f} of {:.0f} MB used", used_mb, most_mb),
                    {"limit of the control group", "", ""}};
    if (most_mb - used_mb < 64) {
      finding.severity = Severity::Wrong;
      finding.problem.what = "the kernel kills the robot when the limit is reached";
      finding.problem.way_out = "raise it: MemoryMax= of the service, --memory of the container (" + folder + ")";
    }
    findings.push_back(std::move(finding));
  }
  const auto quota = words_of(machine.text(folder + "/cpu.max").value_or(""));
  if (quota.size() == 2 && quota[0] != "max") {
    const double cores = static_cast<double>(leading_number(quota[0]).value_or(0)) /
                         static_cast<double>(std::max<std::int64_t>(1, leading_number(quota[1]).value_or(1)));
    findings.push_back(
        {Severity::Advice,
         kMemory,
         fmt::format("{:.2f} cores", cores),
         {"CPU limit of the control group", "the kernel stops every thread when the share of a period is used up",
          "raise it: CPUQuota= of the service, --cpus of the container"}});
  }
}

}  // namespace

void check_memory(const Machine& machine, const Wanted&, Findings& findings) {
  const auto total = meminfo_mb(machine, "MemTotal"), available = meminfo_mb(machine, "MemAvailable");
  if (total && available) {
    Finding finding{
        Severity::Fine, kMemory, fmt::format("{:.0f} of {:.0f} MB available", *available, *total), {"memory", "", ""}};
    if (*available < 100) {
      finding.severity = Severity::Wrong;
      finding.problem.what = "the kernel is about to end programs";
      finding.problem.way_out = "end programs that are not needed: ps -eo rss,pid,comm --sort=-rss | head";
    }
    findings.push_back(std::move(finding));
  }
  const auto swap = meminfo_mb(machine, "SwapTotal"), swap_free = meminfo_mb(machine, "SwapFree");
  if (swap && swap_free) {
    const double used = *swap - *swap_free;
    Finding finding{Severity::Fine,
                    kMemory,
                    *swap < 1 ? "none" : fmt::format("{:.0f} of {:.0f} MB used", used, *swap),
                    {"swap", "", ""}};
    if (used > 64) {
      finding.severity = Severity::Advice;
      finding.problem.what = "a page that must be read back stops its thread for milliseconds";
      finding.problem.way_out = "free memory, then `sudo swapoff -a && sudo swapon -a`";
    }
    findings.push_back(std::move(finding));
  }
  check_cgroup(machine, findings);
}

}  // namespace nacelle::doctor
