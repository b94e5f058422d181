// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "transport_dds/wire/export_rules.hpp"
#include "transport_dds/wire/ros_environment.hpp"
#include "transport_dds/wire/security_files.hpp"

namespace nacelle::transport_dds {

/// The programs that can see the container.
enum class NetworkMode : std::uint8_t {
  Off,    ///< No network: no participant is made.
  Local,  ///< This machine.
  Export  ///< Other machines too.
};
[[nodiscard]] const char* to_text(NetworkMode mode);
/// "off", "local", "export". Errors: NetworkFault::WrongSetting without `where`, with the nearest word.
[[nodiscard]] Result<NetworkMode, Problem> parse_network_mode(std::string_view text);

/// The launch file's `network:`, as written. What is not written is not given.
struct NetworkWish {
  std::optional<NetworkMode> mode;
  std::optional<int> domain_id;
  std::vector<std::string> interfaces;  ///< Names ("eth0") or addresses of this machine.
  std::vector<std::string> peers;
  std::vector<ExportRule> exports;
  bool allow_load = false;      ///< Others may load and unload components.
  bool remote_control = false;  ///< Others may release emergency stops, change the network and end the robot.
  /// `security:`; without keystore or enclave the environment's are taken.
  std::optional<SecurityWish> security;
};

/// How others are found.
enum class Reach : std::uint8_t {
  None,
  ThisMachine,  ///< On lo and on the LAN's interfaces as programs of this machine use them; nothing leaves it.
  Unicast,      ///< No multicast: this machine and the peers are asked, as rmw_cyclonedds does for LOCALHOST.
  Multicast,    ///< The network's other machines, and the peers.
  AsConfigured  ///< SYSTEM_DEFAULT: Cyclone's own settings.
};

/// What is in force.
struct NetworkSettings {
  NetworkMode mode = NetworkMode::Local;
  Reach discovery = Reach::ThisMachine;
  int domain = 0;
  std::vector<std::string> interfaces;  ///< Empty: Cyclone's choice. With ThisMachine lo and the LAN's.
  std::vector<std::string> peers;       ///< With Unicast and Multicast.
  std::vector<ExportRule> exports;      ///< Empty: every topic.
  bool allow_load = false, remote_control = false;
  SecurityWish security;             ///< The requested security.
  std::optional<SecuredBy> secured;  ///< The actual security; set by the code that reads the files. Nothing: unsecured.
  std::string cyclonedds_uri;        ///< Read by Cyclone after Nacelle's configuration, so it takes precedence.
  std::string because_of;            ///< What set the mode: "network: mode", "ROS_LOCALHOST_ONLY"; empty: the default.
  /// One line for each request that is not met, for the bring-up and `nacelle doctor net`.
  std::vector<Problem> remarks;
};

/// Puts launch file and environment together. The launch file wins; where they differ there is a remark.
///
/// If neither sets a mode: Local, for the programs of this machine. Peers without a mode or a range mean Export to them
/// only. In mode Local and Off peers are not asked, and interfaces are not chosen. In mode Export a launch file keeps
/// the environment's way to find others, since two programs of one machine meet only if both do it alike.
/// Errors: NetworkFault::WrongSetting; `where` is "network: KEY" or the variable.
[[nodiscard]] Result<NetworkSettings, Problem> network_settings(const NetworkWish& launch,
                                                                const Environment& environment);

/// The bring-up's last line: "network: local only; to show it to the LAN: network:=export".
[[nodiscard]] std::string network_line(const NetworkSettings& settings);

}  // namespace nacelle::transport_dds
