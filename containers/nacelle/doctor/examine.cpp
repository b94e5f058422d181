// SPDX-License-Identifier: Apache-2.0
#include "nacelle/doctor/checks.hpp"

namespace nacelle::doctor {

Wanted wanted_by(const launch::Plan& plan) {
  Wanted wanted;
  for (const auto& component : plan.components) {
    const std::string name = component.full_name();
    for (const auto& parameter : component.parameters) {
      if (parameter.value.get_type() != ParameterType::PARAMETER_STRING) continue;
      const auto& path = parameter.value.get<std::string>();
      if (path.rfind("/dev/", 0) == 0) wanted.devices.push_back({path, name + ", parameter " + parameter.name});
    }
    if (component.thread.priority.value_or(0) > 0) wanted.priorities.push_back({*component.thread.priority, name});
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
