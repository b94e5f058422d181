// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/launch/parameter_file.hpp"

namespace nacelle::launch {

/// Who may see the container.
enum class NetworkMode : std::uint8_t { Off, Local, Export };

/// A topic that leaves the machine in mode Export.
struct ExportPlan {
  std::string topic;                  ///< Fully qualified.
  double max_hz = 0;                  ///< 0: every message.
  std::uint64_t max_bytes_per_s = 0;  ///< 0: no limit.
  bool compressed_only = false;       ///< Only the compressed form of an image.
  Place where;
};

/// `security:` below `network:`, in SROS 2's words. What is empty is not given: then ROS 2's variables say it.
struct SecurityPlan {
  std::string keystore;  ///< A folder; a relative one is beside the launch file.
  std::string enclave;   ///< "/robot"
  bool enforced = true;  ///< False: `strategy: Permissive`.
  Place where;
};

/// The launch file's `network:`. What is not written is not given: then ROS 2's variables decide.
struct NetworkPlan {
  bool declared = false;  ///< False: the files have no `network`.
  std::optional<NetworkMode> mode;
  bool mode_by_argument = false;  ///< It is the command line's `network:=MODE`.
  std::optional<int> domain_id;
  std::vector<std::string> interfaces;  ///< Names or addresses of this machine.
  std::vector<std::string> peers;       ///< Hosts that are asked, with multicast and without.
  std::vector<ExportPlan> exports;      ///< Empty: every topic.
  bool allow_load = false;              ///< Others may load and unload components.
  bool remote_control = false;          ///< Others may release emergency stops, change the network and end the robot.
  std::optional<SecurityPlan> security;
  Place where;
};

[[nodiscard]] const char* to_text(NetworkMode mode);  ///< "off", "local", "export"
/// The value of `network:=MODE`. Errors: a Problem with the nearest mode.
[[nodiscard]] Result<NetworkMode, Problem> parse_network_argument(const std::string& value);

}  // namespace nacelle::launch
