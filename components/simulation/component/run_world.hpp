// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "simulation/model/world_model.hpp"

namespace nacelle::simulation {

/// Where and how a world runs.
struct WorldOptions {
  std::string directory;  ///< Gets lidar, imu, base and gps (links to ptys), truth, control and ready. Made if missing.
  WorldSettings settings{};  ///< Seed, robot, errors.
  /// The kernel ends this process when the thread that started it dies (PR_SET_PDEATHSIG). A terminal's Ctrl-C is
  /// left to that parent: it reaches every process of the terminal, and the robot's world must outlive the robot's
  /// shutdown. A SIGINT that a process sends (the parent, when the robot is down) ends the world.
  bool end_with_parent = false;
  /// Who the parent is: if it died before the request above, the world ends at once. 0: unknown.
  std::int64_t parent_pid = 0;
  int stop_descriptor = -1;  ///< A descriptor that can be read when the world shall end, for a host that is no shell.
};

/// What a world did.
struct WorldReport {
  struct Line {
    std::uint64_t sent_bytes{};     ///< Handed to the kernel.
    std::uint64_t dropped_bytes{};  ///< Because the line was full: its reader was too slow.
    std::uint64_t received_bytes{};
  };
  double seconds{};
  std::uint64_t late_steps{};     ///< Steps that were made up for after a delay of the machine.
  std::uint64_t skipped_steps{};  ///< Given up because the machine stood still for longer; the world's clock jumped.
  std::array<Line, kDevices.size()> lines{};  ///< In the order of Device.
};

/// Disconnects a device of a running world, or reconnects it: the line hangs up and its link disappears, or both are
/// made again. `device`: "lidar", "imu", "base" or "gps". The device itself keeps running, like one with a battery. Returns
/// when the world has the request; it acts within milliseconds.
/// Errors: a Problem that names the directory or the device.
[[nodiscard]] Result<void, Problem> plug_device(const std::string& directory, const std::string& device, bool in);

/// Runs the simulated robot in real time until SIGTERM, SIGINT, the parent's death or the stop descriptor.
///
/// The file <directory>/ready appears when every line can be opened, and is the first to go. On the way out all files
/// and links are removed. The calling thread's signal mask is changed while it runs. The thread gets the lowest real-time priority
/// where the process may have it, and keeps it.
/// Errors:  a Problem: no pty, directory not writable, another world runs in the same directory.
/// Threads: the calling one.
[[nodiscard]] Result<WorldReport, Problem> run_world(const WorldOptions& options, const Clock& clock);

}  // namespace nacelle::simulation
