// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "doctor/finding.hpp"
#include "doctor/machine.hpp"
#include "nacelle/launch/plan.hpp"

namespace nacelle::doctor {

/// What a robot requires of its machine. Without a launch file it is empty, and the checks examine what the machine
/// has.
struct Wanted {
  struct Device {
    std::string path;
    std::string by;  ///< "/lidar, parameter port_name"
  };
  std::vector<Device> devices;
  struct Priority {
    int priority = 0;
    std::string by;  ///< "/ekf"
  };
  std::vector<Priority> priorities;  ///< Threads with SCHED_FIFO.
  bool shares_memory = false;        ///< A component runs in a process of its own.
};
/// Adds a device for a string parameter whose value is a path below /dev. Each parameter counts once.
void want_device(Wanted& wanted, const std::string& node, const std::string& parameter, const ParameterValue& value);
[[nodiscard]] Wanted wanted_by(const launch::Plan& plan);

/// Each check appends its findings. Pure except for reads through `machine`.
void check_devices(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_ports(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_clock(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_memory(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_kernel(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_power(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_realtime(const Machine& machine, const Wanted& wanted, Findings& findings);
void check_versions(const Machine& machine, const Wanted& wanted, Findings& findings);

/// Runs all checks, in this order.
[[nodiscard]] Findings examine(const Machine& machine, const Wanted& wanted);

}  // namespace nacelle::doctor
