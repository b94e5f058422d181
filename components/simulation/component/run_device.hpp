// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "simulation/model/serial_device.hpp"

namespace nacelle::simulation {

/// The devices that can be run by themselves, as the drivers' parameter `model` names them: "ld06", "rplidar_a1", ...
[[nodiscard]] std::vector<std::string> device_names();
/// Makes one of them, new and powered, in the middle of a room of 4 m x 4 m; null for another name.
[[nodiscard]] std::unique_ptr<SerialDevice> make_device(const std::string& name, std::uint64_t seed);

/// How a device runs.
struct DeviceRun {
  std::string name;  ///< One of device_names().
  std::string link;  ///< Gets a symbolic link to the pty; empty: none.
  std::uint64_t seed = 1;
  int stop_descriptor = -1;  ///< A descriptor that can be read when the device shall end, for a host that is no shell.
};

/// Runs a simulated device behind a pty, in real time, until SIGTERM, SIGINT or the stop descriptor. A pty has no modem lines: a
/// motor that DTR drives always turns. `on_ready` gets the pty's path ("/dev/pts/7") once it can be opened.
/// Errors:  a Problem: no such device (with the names), no pty, the link is in the way.
/// Threads: the calling one, whose signal mask is changed meanwhile.
[[nodiscard]] Result<void, Problem> run_device(const DeviceRun& run, const Clock& clock,
                                               const std::function<void(const std::string& path)>& on_ready);

}  // namespace nacelle::simulation
