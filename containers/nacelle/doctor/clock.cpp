// SPDX-License-Identifier: Apache-2.0
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

constexpr const char* kClock = "clock";

std::string date_of(WallTime time) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S} UTC",
                     fmt::gmtime(static_cast<std::time_t>(time.nanoseconds() / 1'000'000'000)));
}

/// A program that keeps the clock, and runs.
std::string keeper(const Machine& machine) {
  for (const auto& entry : machine.names_in("/proc")) {
    std::string name = machine.text("/proc/" + entry + "/comm").value_or("");
    for (const char* const known : {"systemd-timesyn", "chronyd", "ntpd", "ntpsec", "ptp4l", "phc2sys"}) {
      if (name == known) return name;
    }
  }
  return {};
}

}  // namespace

void check_clock(const Machine& machine, const Wanted&, Findings& findings) {
  const Facts& facts = machine.facts();
  const bool has_rtc = !machine.names_in("/sys/class/rtc").empty();
  if (facts.now < facts.built) {
    findings.push_back(
        {Severity::Wrong,
         kClock,
         date_of(facts.now),
         {"wall clock", "is earlier than the program's installation (" + date_of(facts.built) + ")",
          "it will jump when it is set: wait for the network's time (`timedatectl`), or set it (`sudo date -s`)"}});
  }
  const std::string by = keeper(machine);
  if (!facts.clock_is_synchronised) {
    findings.push_back(
        {Severity::Fine, kClock, "the kernel does not report whether it is synchronised", {"wall clock", "", ""}});
  } else if (*facts.clock_is_synchronised) {
    findings.push_back(
        {Severity::Fine, kClock, "synchronised" + (by.empty() ? "" : " by " + by), {"wall clock", "", ""}});
  } else {
    findings.push_back({Severity::Advice,
                        kClock,
                        "not synchronised",
                        {"wall clock", "stamps do not compare with other machines', and may jump when it is set",
                         by.empty() ? "sudo apt install systemd-timesyncd (or chrony), then `timedatectl set-ntp true`"
                                    : by + " runs, but has had no answer: is there a network?"}});
  }
  if (has_rtc) {
    findings.push_back({Severity::Fine, kClock, "is there", {"battery clock (RTC)", "", ""}});
  } else {
    findings.push_back(
        {Severity::Advice,
         kClock,
         "none",
         {"battery clock (RTC)", "after a power cut the wall clock is wrong until a network answers",
          "fit one (Raspberry Pi 5: its battery; others: DS3231), or start the robot after time-sync.target"}});
  }
}

}  // namespace nacelle::doctor
