// SPDX-License-Identifier: Apache-2.0
#include "doctor/checks.hpp"

namespace nacelle::doctor {

void want_device(Wanted& wanted, const std::string& node, const std::string& parameter, const ParameterValue& value) {
  const auto* const path = std::get_if<std::string>(&value);
  if (path == nullptr || path->rfind("/dev/", 0) != 0) return;
  std::string by = node + ", parameter " + parameter;
  for (const auto& device : wanted.devices) {
    if (device.by == by) return;
  }
  wanted.devices.push_back({*path, std::move(by)});
}

Wanted wanted_by(const launch::Plan& plan) {
  Wanted wanted;
  for (const auto& component : plan.components) {
    const std::string name = component.full_name();
    for (const auto& parameter : component.parameters) { want_device(wanted, name, parameter.name, parameter.value); }
    if (component.thread.priority > 0) wanted.priorities.push_back({component.thread.priority, name});
    wanted.shares_memory = wanted.shares_memory || component.isolate == launch::Isolation::Process;
  }
  return wanted;
}

Findings examine(const Machine& machine, const Wanted& wanted) {
  Findings findings;
  for (const auto check : {check_devices, check_ports, check_clock, check_memory, check_kernel, check_power,
                           check_realtime, check_versions})
    check(machine, wanted, findings);
  return findings;
}

}  // namespace nacelle::doctor
