// SPDX-License-Identifier: Apache-2.0
#include "transport_dds/wire/network_settings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nacelle/base/names.hpp"
#include "transport_dds/wire/network_fault.hpp"

namespace nacelle::transport_dds {
namespace {

const std::vector<std::string> kModes{"off", "local", "export"};

Problem at(std::string_view key, const std::string& value, const Problem& problem) {
  return {"network: " + std::string(key), problem.what, problem.way_out, NetworkFault::WrongSetting, value};
}

Result<void, Problem> validate_rule(const ExportRule& rule) {
  if (auto valid = validate_full_topic_name(rule.topic); !valid) return valid;
  if (std::isfinite(rule.max_hz) && rule.max_hz >= 0.0) return {};
  return err(Problem{"", "max_hz of " + rule.topic + " is negative or no number", "0 is every message"});
}

Result<void, Problem> validate(const NetworkWish& wish) {
  if (wish.domain_id) {
    if (auto valid = validate_domain(*wish.domain_id); !valid)
      return err(at("domain_id", std::to_string(*wish.domain_id), valid.error()));
  }
  for (const auto& name : wish.interfaces) {
    if (auto valid = validate_interface(name); !valid) return err(at("interfaces", name, valid.error()));
  }
  for (const auto& peer : wish.peers) {
    if (auto valid = validate_peer(peer); !valid) return err(at("peers", peer, valid.error()));
  }
  for (const auto& rule : wish.exports) {
    if (auto valid = validate_rule(rule); !valid) return err(at("export", rule.topic, valid.error()));
  }
  return {};
}

/// A mode, and its origin.
struct Asked {
  NetworkMode mode = NetworkMode::Local;
  std::string because_of;
};

// What ROS 2's variables mean; nothing if they say nothing of it.
std::optional<Asked> asked_by(const EnvironmentWish& wish) {
  constexpr const char* kRange = "ROS_AUTOMATIC_DISCOVERY_RANGE";
  if (wish.localhost_only) return Asked{NetworkMode::Local, "ROS_LOCALHOST_ONLY"};
  const bool has_peers = !wish.peers.empty();
  if (!wish.range) return has_peers ? std::optional(Asked{NetworkMode::Export, "ROS_STATIC_PEERS"}) : std::nullopt;
  switch (*wish.range) {
    case DiscoveryRange::Off: return Asked{NetworkMode::Off, kRange};
    case DiscoveryRange::Localhost:
      return has_peers ? Asked{NetworkMode::Export, "ROS_STATIC_PEERS"} : Asked{NetworkMode::Local, kRange};
    case DiscoveryRange::Subnet:
    case DiscoveryRange::SystemDefault: break;
  }
  return Asked{NetworkMode::Export, kRange};
}

Asked asked_by(const NetworkWish& launch, const EnvironmentWish& environment) {
  if (launch.mode) return {*launch.mode, "network: mode"};
  const auto asked = asked_by(environment);
  if (!launch.peers.empty() && !asked) return {NetworkMode::Export, "network: peers"};
  return asked.value_or(Asked{});
}

// How others are found on the LAN is the environment's word where there is one: two programs meet only if both do it
// alike. On this machine it is all ways at once.
Reach discovery_of(NetworkMode mode, const NetworkWish& launch, const EnvironmentWish& environment) {
  if (mode == NetworkMode::Off) return Reach::None;
  if (mode == NetworkMode::Local) return Reach::ThisMachine;
  if (environment.range == DiscoveryRange::SystemDefault) return Reach::AsConfigured;
  // Peers without a word that the LAN is meant.
  const bool only_peers = !launch.mode && environment.range != DiscoveryRange::Subnet;
  return only_peers ? Reach::Unicast : Reach::Multicast;
}

void remark_on_differences(const NetworkWish& launch, const EnvironmentWish& environment, NetworkSettings& settings) {
  const auto asked = asked_by(environment);
  if (launch.mode && asked && asked->mode != *launch.mode) {
    settings.remarks.push_back({asked->because_of,
                                std::string("it asks for ") + to_text(asked->mode) + ", the launch file says " +
                                    to_text(*launch.mode) + ", which is in force",
                                "", NetworkFault::Overruled, to_text(asked->mode)});
  }
  if (launch.domain_id && environment.domain && *environment.domain != *launch.domain_id) {
    settings.remarks.push_back({"ROS_DOMAIN_ID",
                                "it says " + std::to_string(*environment.domain) + ", the launch file says " +
                                    std::to_string(*launch.domain_id) + ", which is in force",
                                "", NetworkFault::Overruled, std::to_string(*environment.domain)});
  }
  if (!settings.cyclonedds_uri.empty()) {
    settings.remarks.push_back({"CYCLONEDDS_URI",
                                settings.mode == NetworkMode::Local
                                    ? "Cyclone reads it after Nacelle's settings: it decides which programs of this "
                                      "machine can see the robot"
                                    : "Cyclone reads it after Nacelle's settings: it decides who can see the robot",
                                "unset it to use the network as shown here", NetworkFault::ConfigurationTaken,
                                settings.cyclonedds_uri});
  }
}

// Two words for one thing, of which the launch file's is in force.
void remark_on_difference(const char* variable, const std::string& says, const std::string& in_force,
                          NetworkSettings& settings) {
  if (says.empty() || in_force.empty() || says == in_force) return;
  settings.remarks.push_back({variable,
                              "it says " + says + ", the launch file says " + in_force + ", which is in force", "",
                              NetworkFault::Overruled, says});
}

// If the launch file requests security, the environment cannot disable it.
SecurityWish security_of(const NetworkWish& launch, const EnvironmentWish& asked, const Environment& environment,
                         NetworkSettings& settings) {
  if (!launch.security) return asked.security;
  const SecurityWish& there = asked.security;
  SecurityWish wish = *launch.security;
  wish.enabled = true;
  if (const auto enable = environment.find("ROS_SECURITY_ENABLE"); enable != environment.end() && !there.enabled)
    remark_on_difference("ROS_SECURITY_ENABLE", enable->second, "security", settings);
  if (there.enabled) {
    remark_on_difference("ROS_SECURITY_STRATEGY", strategy_of(there), strategy_of(wish), settings);
    remark_on_difference("ROS_SECURITY_KEYSTORE", there.keystore, wish.keystore, settings);
    remark_on_difference("ROS_SECURITY_ENCLAVE_OVERRIDE", there.enclave, wish.enclave, settings);
  }
  if (wish.keystore.empty()) wish.keystore = there.keystore;
  if (wish.enclave.empty()) wish.enclave = there.enclave;
  return wish;
}

// Peers in order, each once; only where they are asked.
void take_peers(const NetworkWish& launch, const EnvironmentWish& environment, NetworkSettings& settings) {
  const bool asks = settings.mode == NetworkMode::Export && settings.discovery != Reach::AsConfigured;
  const auto take = [&](const std::vector<std::string>& peers, const char* where) {
    if (!asks && !peers.empty()) {
      settings.remarks.push_back({where, "peers are not asked in this mode", "network:=export shows the robot to them",
                                  NetworkFault::PeersUnused, join(peers)});
    }
    for (const auto& peer : peers) {
      const bool is_new = std::find(settings.peers.begin(), settings.peers.end(), peer) == settings.peers.end();
      if (asks && is_new) settings.peers.push_back(peer);
    }
  };
  take(launch.peers, "network: peers");
  if (!environment.localhost_only) take(environment.peers, "ROS_STATIC_PEERS");
}

}  // namespace

const char* to_text(NetworkMode mode) { return kModes[static_cast<std::size_t>(mode)].c_str(); }

Result<NetworkMode, Problem> parse_network_mode(std::string_view text) {
  const auto found = std::find(kModes.begin(), kModes.end(), text);
  if (found != kModes.end()) return static_cast<NetworkMode>(found - kModes.begin());
  return err(Problem{"", "'" + std::string(text.substr(0, 80)) + "' is not a mode of the network",
                     suggestion(text, kModes), NetworkFault::WrongSetting, std::string(text)});
}

Result<NetworkSettings, Problem> network_settings(const NetworkWish& launch, const Environment& environment) {
  if (auto valid = validate(launch); !valid) return err(valid.error());
  auto asked = read_environment(environment);
  if (!asked) return err(asked.error());

  Asked mode = asked_by(launch, *asked);
  NetworkSettings settings;
  settings.mode = mode.mode;
  settings.discovery = discovery_of(mode.mode, launch, *asked);
  settings.because_of = std::move(mode.because_of);
  settings.domain = launch.domain_id.value_or(asked->domain.value_or(0));
  settings.interfaces = settings.discovery == Reach::ThisMachine ? std::vector<std::string>{"lo"} : launch.interfaces;
  settings.exports = launch.exports;
  settings.allow_load = launch.allow_load;
  settings.remote_control = launch.remote_control;
  settings.cyclonedds_uri = asked->cyclonedds_uri;
  settings.remarks = asked->remarks;
  settings.security = security_of(launch, *asked, environment, settings);
  remark_on_differences(launch, *asked, settings);
  take_peers(launch, *asked, settings);
  return settings;
}

std::string network_line(const NetworkSettings& settings) {
  std::string line = "network: ";
  switch (settings.mode) {
    case NetworkMode::Off: return line + "off; to let tools of this machine see it: network:=local";
    case NetworkMode::Local: line += "local only"; break;
    case NetworkMode::Export:
      line += settings.discovery == Reach::Unicast ? "shown to " + join(settings.peers) : "shown to the LAN";
      break;
  }
  if (settings.domain != 0) line += ", domain " + std::to_string(settings.domain);
  if (settings.secured) {
    line += ", secured as " + settings.secured->enclave;
  } else if (settings.security.enabled) {
    line += ", without the security that was requested";
  }
  if (!settings.cyclonedds_uri.empty()) line += ", as CYCLONEDDS_URI allows";
  return line + (settings.mode == NetworkMode::Local ? "; to show it to the LAN: network:=export"
                                                     : "; to keep it on this machine: network:=local");
}

}  // namespace nacelle::transport_dds
