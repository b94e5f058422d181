// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/network_names.hpp"
#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::transport_dds {

/// Environment variables of a process: at least those whose names begin with ROS_, RMW_ or CYCLONEDDS_.
using Environment = std::map<std::string, std::string, std::less<>>;

using nacelle::kMostDomain;

/// ROS_AUTOMATIC_DISCOVERY_RANGE.
enum class DiscoveryRange : std::uint8_t { Off, Localhost, Subnet, SystemDefault };
[[nodiscard]] const char* to_text(DiscoveryRange range);

/// The settings of SROS 2's variables, or of a launch file's `security:`.
struct SecurityWish {
  bool enabled = false;   ///< ROS_SECURITY_ENABLE is "true". Otherwise ROS 2 ignores the other variables.
  bool enforced = false;  ///< ROS_SECURITY_STRATEGY is "Enforce": without its files the process must not join.
  std::string keystore;   ///< A directory.
  std::string enclave;    ///< ROS_SECURITY_ENCLAVE_OVERRIDE; empty: "/".
  friend bool operator==(const SecurityWish&, const SecurityWish&) = default;
};
/// Returns "Enforce" or "Permissive".
[[nodiscard]] const char* strategy_of(const SecurityWish& wish);

/// The settings of ROS 2's variables, without defaults.
struct EnvironmentWish {
  std::optional<int> domain;
  std::optional<DiscoveryRange> range;
  bool localhost_only = false;  ///< ROS_LOCALHOST_ONLY=1, which overrides range and peers.
  std::vector<std::string> peers;
  std::string cyclonedds_uri;
  SecurityWish security;
  /// Warnings, one for each variable that is ignored, deprecated or read in another way; `where` is its name.
  std::vector<Problem> remarks;
};

/// Reads ROS 2's variables as rcl and rmw_cyclonedds do. An empty variable counts as not set.
///
/// Every variable named ROS_... or RMW_... is used, only describes an installation (ROS_DISTRO), or gets a warning.
/// Errors: an invalid ROS_DOMAIN_ID. rcl refuses it too, except that it ignores characters after the digits.
/// Source: domain_id.c, localhost.c, discovery_options.c, security.c, init.c of rcl (jazzy).
[[nodiscard]] Result<EnvironmentWish, Problem> read_environment(const Environment& environment);

}  // namespace nacelle::transport_dds
