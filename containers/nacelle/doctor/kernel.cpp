// SPDX-License-Identifier: Apache-2.0
// Settings of the kernel, and the power that a board gets.
#include <fmt/format.h>

#include <cstdlib>
#include <sstream>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

constexpr const char* kKernel = "kernel";

struct Setting {
  const char* path;  // below /proc/sys
  std::int64_t least;
  const char* unit;
  const char* what;  // happens below it
};
// Messages above 64 kB travel over UDP in fragments; docs.ros.org, "DDS tuning information".
constexpr Setting kSettings[] = {
    {"net/core/rmem_max", 4 << 20, "B", "large messages from the network overflow the socket"},
    {"net/ipv4/ipfrag_high_thresh", 4 << 20, "B",
     "fragments of large messages are dropped while others are put together"},
};

void check_settings(const Machine& machine, Findings& findings) {
  for (const auto& setting : kSettings) {
    const auto value = machine.number(std::string{"/proc/sys/"} + setting.path);
    if (!value) continue;
    std::string name = setting.path;
    for (char& c : name) c = c == '/' ? '.' : c;
    Finding finding{Severity::Fine, kKernel, fmt::format("{} {}", *value, setting.unit), {name, "", ""}};
    if (*value < setting.least) {
      finding.severity = Severity::Advice;
      finding.problem.what = setting.what;
      finding.problem.way_out = fmt::format("sudo sysctl -w {}={}", name, setting.least);
    }
    findings.push_back(std::move(finding));
  }
  if (const auto runtime = machine.number("/proc/sys/kernel/sched_rt_runtime_us")) {
    Finding finding{Severity::Fine, kKernel, fmt::format("{} us", *runtime), {"kernel.sched_rt_runtime_us", "", ""}};
    if (*runtime == -1 || *runtime == 0) {
      finding.severity = Severity::Advice;
      finding.problem.what = *runtime == 0 ? "threads with a real-time priority never run"
                                           : "a spinning thread with real-time priority blocks its core forever";
      finding.problem.way_out = "sudo sysctl -w kernel.sched_rt_runtime_us=950000";
    }
    findings.push_back(std::move(finding));
  }
}

/// "64M", "65536k", or a plain number of bytes. Source: tmpfs(5).
double megabytes_of(const std::string& size, double ram_mb) {
  const auto number = static_cast<double>(leading_number(size).value_or(0));
  switch (size.empty() ? '\0' : size.back()) {
    case 'k':
    case 'K': return number * 1024 / 1e6;
    case 'm':
    case 'M': return number * 1024 * 1024 / 1e6;
    case 'g':
    case 'G': return number * 1024 * 1024 * 1024 / 1e6;
    case '%': return ram_mb * number / 100;
    default: return number / 1e6;
  }
}

void check_shared_memory(const Machine& machine, const Wanted& wanted, Findings& findings) {
  std::istringstream lines{machine.text("/proc/self/mounts").value_or("")};
  for (std::string line; std::getline(lines, line);) {
    const auto words = words_of(line);
    if (words.size() < 4 || words[1] != "/dev/shm") continue;
    const auto ram = leading_number(machine.field("/proc/meminfo", "MemTotal").value_or(""));
    const double ram_mb = static_cast<double>(ram.value_or(0)) * 1024 / 1e6;
    const std::size_t at = (',' + words[3]).find(",size=");
    const double size_mb = at == std::string::npos
                               ? ram_mb / 2
                               : megabytes_of(words[3].substr(at + 5, words[3].find(',', at) - at - 5), ram_mb);
    Finding finding{Severity::Fine, kKernel, fmt::format("{:.0f} MB", size_mb), {"/dev/shm", "", ""}};
    if (size_mb < 256) {
      finding.severity = wanted.shares_memory ? Severity::Wrong : Severity::Advice;
      finding.problem.what = "too little for large messages between processes";
      finding.problem.way_out = "--shm-size=1g of the container, or sudo mount -o remount,size=1g /dev/shm";
    }
    findings.push_back(std::move(finding));
    return;
  }
  findings.push_back(
      {wanted.shares_memory ? Severity::Wrong : Severity::Advice,
       kKernel,
       "not mounted",
       {"/dev/shm", "components in processes of their own cannot share memory", "mount -t tmpfs tmpfs /dev/shm"}});
}

void check_governor(const Machine& machine, Findings& findings) {
  const auto governor = machine.text("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (!governor) return;  // a virtual machine has none
  Finding finding{Severity::Fine, kKernel, *governor, {"CPU governor", "", ""}};
  if (*governor == "powersave" || *governor == "conservative") {
    finding.severity = Severity::Advice;
    finding.problem.what = "the clock is raised late: callbacks after a pause take longer";
    finding.problem.way_out = "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
  }
  findings.push_back(std::move(finding));
}

}  // namespace

void check_kernel(const Machine& machine, const Wanted& wanted, Findings& findings) {
  check_settings(machine, findings);
  check_shared_memory(machine, wanted, findings);
  check_governor(machine, findings);
}

void check_power(const Machine& machine, const Wanted&, Findings& findings) {
  // The Raspberry Pi's firmware: bits 0 to 3 are now, 16 to 19 since boot.
  if (const auto text = machine.text("/sys/devices/platform/soc/soc:firmware/get_throttled")) {
    const unsigned long bits = std::strtoul(text->c_str(), nullptr, 16);
    Finding finding{Severity::Fine, "power", "enough", {"Raspberry Pi's supply", "", ""}};
    if ((bits & 0x50005UL) != 0) {
      const bool now = (bits & 0x5UL) != 0;
      finding.severity = now ? Severity::Wrong : Severity::Advice;
      finding.value = fmt::format("{} (0x{:x})", now ? "under-voltage now" : "under-voltage since boot", bits);
      finding.problem.what = "the board slows down, and its USB devices drop out";
      finding.problem.way_out =
          "a supply with 5 V at 3 A (Raspberry Pi 5: 5 A), a short thick cable, motors on another supply";
    } else if ((bits & 0xA000AUL) != 0) {
      finding.severity = (bits & 0xAUL) != 0 ? Severity::Wrong : Severity::Advice;
      finding.value = fmt::format("slowed down for its temperature (0x{:x})", bits);
      finding.problem.what = "callbacks take longer than measured on a cool board";
      finding.problem.way_out = "cool it: a heat sink with a fan";
    }
    findings.push_back(std::move(finding));
  }
  std::optional<double> hottest;
  for (const auto& zone : machine.names_in("/sys/class/thermal")) {
    const auto millidegrees = machine.number("/sys/class/thermal/" + zone + "/temp");
    if (!millidegrees || zone.rfind("thermal_zone", 0) != 0) continue;
    hottest = std::max(hottest.value_or(-273.0), static_cast<double>(*millidegrees) / 1000);
  }
  if (hottest) {
    Finding finding{Severity::Fine, "power", fmt::format("{:.0f} C", *hottest), {"temperature", "", ""}};
    if (*hottest >= 80) {
      finding.severity = Severity::Advice;
      finding.problem.what = "most boards slow down from here on";
      finding.problem.way_out = "cool it: a heat sink with a fan";
    }
    findings.push_back(std::move(finding));
  }
}

}  // namespace nacelle::doctor
