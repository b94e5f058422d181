// SPDX-License-Identifier: Apache-2.0
// Cameras and serial lines: present, accessible, and not in use by another program.
#include <fmt/format.h>

#include <algorithm>

#include "doctor/checks.hpp"

namespace nacelle::doctor {
namespace {

constexpr const char* kDevices = "devices";

// Serial lines of a PC's board (ttyS) are there with or without a chip, and mean nothing.
bool is_device_of_a_robot(const std::string& name) {
  for (const char* const beginning : {"ttyUSB", "ttyACM", "ttyAMA", "video"}) {
    if (name.rfind(beginning, 0) == 0) return true;
  }
  return false;
}

std::string described(const Machine& machine, const Access& access) {
  std::string bits;
  for (const unsigned shift : {6U, 3U, 0U}) {
    const unsigned class_bits = access.mode >> shift;
    bits += (class_bits & 4U) != 0 ? 'r' : '-';
    bits += (class_bits & 2U) != 0 ? 'w' : '-';
  }
  return fmt::format("{} of group {}", bits, machine.group_name(access.group));
}

std::string others_like(const Machine& machine, const std::string& path) {
  std::vector<std::string> there;
  for (const auto& name : machine.names_in("/dev")) {
    if (is_device_of_a_robot(name)) there.push_back("/dev/" + name);
  }
  if (there.empty()) return "is it plugged in and powered? `dmesg | tail` names what was plugged in";
  // A camera is not meant by a serial line's path.
  const bool video = path.find("video") != std::string::npos;
  std::erase_if(there, [&](const std::string& other) { return (other.find("video") != std::string::npos) != video; });
  return there.empty() ? "is it plugged in and powered?" : "there are " + join(there) + "; give that one instead";
}

bool is_ours(const std::vector<Process>& holders) {
  return std::all_of(holders.begin(), holders.end(), [](const Process& p) { return p.name == "nacelle"; });
}

void look_at(const Machine& machine, const std::string& path, const std::string& by, Findings& findings) {
  Finding finding{Severity::Fine, kDevices, "", {path, "", ""}};
  if (!by.empty()) finding.problem.where.words += " (" + by + ")";
  const std::string target = machine.resolved(path);
  const auto access = machine.access(path);
  if (!access) {
    finding.severity = Severity::Wrong;
    finding.problem.what = "is not there";
    finding.problem.way_out = others_like(machine, path);
    findings.push_back(std::move(finding));
    return;
  }
  finding.value = (target == path ? "" : "-> " + target + ", ") + described(machine, *access);
  const auto holders = machine.holders(target);
  if (!machine.may_use(*access)) {
    const bool by_group = (access->mode & 060U) == 060U;
    finding.severity = Severity::Wrong;
    finding.problem.what = "this user may not open it";
    finding.problem.way_out =
        by_group ? fmt::format("sudo usermod -aG {} $USER, then log in again", machine.group_name(access->group))
                 : fmt::format("sudo chmod g+rw {}, or a udev rule with MODE=\"0660\"", target);
  } else if (!holders.empty()) {
    finding.value += ", held by " + names_of(holders);
    if (!is_ours(holders)) {
      finding.severity = by.empty() ? Severity::Advice : Severity::Wrong;
      finding.problem.what = "another program reads it";
      finding.problem.way_out = fmt::format("end it: kill {}", holders.front().pid);
      if (holders.front().name == "ModemManager")
        finding.problem.way_out = "it probes serial lines: sudo systemctl disable --now ModemManager";
    }
  }
  findings.push_back(std::move(finding));
}

}  // namespace

void check_devices(const Machine& machine, const Wanted& wanted, Findings& findings) {
  for (const auto& device : wanted.devices) look_at(machine, device.path, device.by, findings);
  if (!wanted.devices.empty()) return;
  const std::size_t before = findings.size();
  for (const auto& name : machine.names_in("/dev")) {
    if (is_device_of_a_robot(name)) look_at(machine, "/dev/" + name, "", findings);
  }
  if (findings.size() == before)
    findings.push_back({Severity::Fine, kDevices, "no camera and no serial line is plugged in", {"/dev", "", ""}});
}

}  // namespace nacelle::doctor
