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

/// The variables of a process: all of them, or those that begin with ROS_, RMW_ and CYCLONEDDS_.
using Environment = std::map<std::string, std::string, std::less<>>;

using nacelle::kMostDomain;

/// ROS_AUTOMATIC_DISCOVERY_RANGE.
enum class DiscoveryRange : std::uint8_t { Off, Localhost, Subnet, SystemDefault };
[[nodiscard]] const char* to_text(DiscoveryRange range);

/// SROS 2's variables, or a launch file's `security:`.
struct SecurityWish {
  bool enabled = false;   ///< ROS_SECURITY_ENABLE is "true"; ROS 2 reads the others only then.
  bool enforced = false;  ///< ROS_SECURITY_STRATEGY is "Enforce": without its files the process must not speak at all.
  std::string keystore;   ///< A directory.
  std::string enclave;    ///< ROS_SECURITY_ENCLAVE_OVERRIDE; empty: "/".
  friend bool operator==(const SecurityWish&, const SecurityWish&) = default;
};
/// "Enforce" or "Permissive".
[[nodiscard]] const char* strategy_of(const SecurityWish& wish);

/// What ROS 2's variables ask for. What is not set is not given.
struct EnvironmentWish {
  std::optional<int> domain;
  std::optional<DiscoveryRange> range;
  bool localhost_only = false;  ///< ROS_LOCALHOST_ONLY=1, which overrides range and peers.
  std::vector<std::string> peers;
  std::string cyclonedds_uri;
  SecurityWish security;
  /// One line for each variable that is not simply obeyed: `where` is its name.
  std::vector<Problem> remarks;
};

/// Reads them as rcl and rmw_cyclonedds do; a variable that is set to nothing is not set.
///
/// Every variable named ROS_... or RMW_... is obeyed, is a mere description of an installation (ROS_DISTRO), or gets a
/// remark.
/// Errors: a domain that is none (rcl refuses to start, too, but for what stands behind the digits).
/// Source: domain_id.c, localhost.c, discovery_options.c, security.c, init.c of rcl (jazzy).
[[nodiscard]] Result<EnvironmentWish, Problem> read_environment(const Environment& environment);

}  // namespace nacelle::transport_dds
