// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"

namespace nacelle::io {

/// A process as /proc shows it.
struct Process {
  int pid = 0;
  std::string name;
  friend bool operator==(const Process&, const Process&) = default;
};

/// Returns the processes with a descriptor whose link in /proc/PID/fd is `target`: a path, or "socket:[1234]".
///
/// Only root sees the processes of other users. The watcher process of a container is left out: it shares the container's open files, and
/// ends with it. `root`: where the machine's files are; tests replace it.
[[nodiscard]] std::vector<Process> holders_of(const std::string& target, const std::filesystem::path& root = "/");

/// Returns "modem (pid 12), cat (pid 14)".
[[nodiscard]] std::string names_of(const std::vector<Process>& processes);

/// Returns paths of serial devices that are plugged in, those of /dev/serial/by-id first: they name a device however it was plugged in.
[[nodiscard]] std::vector<std::string> serial_devices(const std::filesystem::path& root = "/");

/// Says why a device could not be opened, for a person beside the robot: the group that is missing, the program that has it open, or what
/// is there instead of it. `os_code`: errno of the attempt; EBUSY also for a lock that another program holds.
[[nodiscard]] Problem why_not_opened(const std::string& path, int os_code, const std::filesystem::path& root = "/");

}  // namespace nacelle::io
