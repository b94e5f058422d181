// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "nacelle/base/time.hpp"
#include "nacelle/launch/network_plan.hpp"
#include "transport_dds/wire/network_settings.hpp"

namespace nacelle::networking {

/// Returns whether this program was built with Cyclone DDS.
[[nodiscard]] bool network_is_built_in();
/// Returns the problem of a build without Cyclone DDS that is to join a network.
[[nodiscard]] Problem network_is_not_built_in(const Place& where);

/// Returns the problem of a build without OpenSSL that is to use DDS Security.
[[nodiscard]] Problem security_is_not_built_in(const Place& where);

/// Returns the environment variables of this process that begin with ROS_, RMW_ or CYCLONEDDS_.
[[nodiscard]] transport_dds::Environment ros_environment();

/// Combines launch file and environment. Adds remarks for the user, also about ports. Reads the security files, checks
/// them against the clock's wall time, and reads the kernel's range of ports.
/// Errors: as transport_dds::network_settings(); security that is enforced but cannot be set up, with the file.
[[nodiscard]] Result<transport_dds::NetworkSettings, Problem> network_in_force(
    const launch::NetworkPlan& plan, const transport_dds::Environment& environment, const Clock& clock = SystemClock{});

/// Returns "network: off, since <why>; the robot runs without it".
[[nodiscard]] std::string network_off_line(const Problem& why);

/// Returns an object with the keys mode, because_of, discovery, domain, ports, interfaces, peers, exports, allow_load,
/// remote_control, security, cyclonedds_uri, remarks, line.
[[nodiscard]] nlohmann::json json_of(const transport_dds::NetworkSettings& settings);

}  // namespace nacelle::networking
