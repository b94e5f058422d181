// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/io/can_port.hpp"
#include "simulation/protocol/motor_device.hpp"

namespace nacelle::simulation {

/// The devices that can be run on a CAN interface, as the base's parameter `hardware` names them: "odrive_can", "vesc_can".
[[nodiscard]] std::vector<std::string> can_device_names();
/// Makes one of them, new and powered: an ODrive with the nodes 0 and 1, or VESCs with the ids 7 and 42. Null for another name.
[[nodiscard]] std::unique_ptr<MotorDevice> make_can_device(const std::string& name);

/// How a device on a CAN bus runs.
struct CanDeviceRun {
  std::string name;          ///< One of can_device_names().
  std::string interface;     ///< "vcan0"
  int stop_descriptor = -1;  ///< A descriptor that can be read when the device shall end, for a host that is no shell.
};

/// Runs a simulated device on a CAN interface, in real time, until SIGTERM, SIGINT or the stop descriptor. Its wheels turn as commanded. An
/// interface that is set down or goes away meanwhile is waited for. `on_ready` is called once the device is on the bus.
/// Errors:  a Problem: no such device (with the names), no such interface (with the commands that make a virtual one), or it is down.
/// Threads: the calling one, whose signal mask is changed meanwhile.
[[nodiscard]] Result<void, Problem> run_can_device(const CanDeviceRun& run, const Clock& clock,
                                                   const std::function<void()>& on_ready);

/// As run_can_device(), on a port that is open, until `ends` returns true. It gets how long it may wait for the end.
void serve_can_device(MotorDevice& device, io::CanPort& port, const Clock& clock,
                      const std::function<bool(Duration wait)>& ends);

}  // namespace nacelle::simulation
