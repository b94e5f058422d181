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

/// Which programs can see the container.
enum class NetworkMode : std::uint8_t {
  Off,    ///< None: no participant is made.
  Local,  ///< Those of this machine.
  Export  ///< Those of other machines too.
};
[[nodiscard]] const char* to_text(NetworkMode mode);
/// Parses "off", "local" or "export". Errors: NetworkFault::WrongSetting without `where`; suggests the nearest word.
[[nodiscard]] Result<NetworkMode, Problem> parse_network_mode(std::string_view text);

/// The launch file's `network:` as written, without defaults.
struct NetworkWish {
  std::optional<NetworkMode> mode;
  std::optional<int> domain_id;
  std::vector<std::string> interfaces;  ///< Names ("eth0") or addresses of this machine.
  std::vector<std::string> peers;
  std::vector<ExportRule> exports;
  bool allow_load = false;      ///< Remote callers may load and unload components.
  bool remote_control = false;  ///< Remote callers may release emergency stops, change the network and end the robot.
  /// `security:`. A missing keystore or enclave is taken from the environment.
  std::optional<SecurityWish> security;
};

/// How other participants are discovered.
enum class Reach : std::uint8_t {
  None,
  ThisMachine,  ///< By multicast and unicast on lo, and on the LAN's addresses of this machine; nothing leaves it.
  Unicast,      ///< Without multicast: contacts this machine and the peers, as rmw_cyclonedds does for LOCALHOST.
  Multicast,    ///< By multicast on the network, and by contacting the peers.
  AsConfigured  ///< SYSTEM_DEFAULT: Cyclone's own settings.
};

/// The settings in force.
struct NetworkSettings {
  NetworkMode mode = NetworkMode::Local;
  Reach discovery = Reach::ThisMachine;
  int domain = 0;
  std::vector<std::string> interfaces;  ///< Empty: Cyclone's choice. With ThisMachine: lo and those of the LAN.
  std::vector<std::string> peers;       ///< Used with Unicast and Multicast only.
  std::vector<ExportRule> exports;      ///< Empty: every topic.
  bool allow_load = false, remote_control = false;
  SecurityWish security;             ///< The requested security.
  std::optional<SecuredBy> secured;  ///< The actual security; set by the code that reads the files. Nothing: unsecured.
  std::string cyclonedds_uri;        ///< Read by Cyclone after Nacelle's configuration, so it takes precedence.
  std::string because_of;            ///< What set the mode: "network: mode", "ROS_LOCALHOST_ONLY"; empty: the default.
  /// Warnings, one for each setting that is overridden, ignored or unsafe to rely on. The bring-up and `nacelle doctor
  /// net` show them.
  std::vector<Problem> remarks;
};

/// Merges the launch file and the environment. The launch file takes precedence; a warning reports each difference.
///
/// If neither sets a mode, it is Local. If neither sets a mode or a range, peers set the mode to Export and the reach
/// to Unicast: only this machine and the peers are contacted. ROS_STATIC_PEERS do the same with the range LOCALHOST. In
/// the modes Local and Off, peers are not contacted, a warning reports them, and Local ignores the interfaces of the
/// launch file. In mode Export, the range SYSTEM_DEFAULT stays in force and leaves discovery, peers included, to
/// Cyclone's settings, because two programs of one machine discover each other only if both use the same way.
/// Errors: NetworkFault::WrongSetting; `where` is "network: KEY" or the variable.
[[nodiscard]] Result<NetworkSettings, Problem> network_settings(const NetworkWish& launch,
                                                                const Environment& environment);

/// Returns the bring-up's last line: "network: local only; to show it to the LAN: network:=export".
[[nodiscard]] std::string network_line(const NetworkSettings& settings);

}  // namespace nacelle::transport_dds
