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

/// Whether this program was built with Cyclone DDS.
[[nodiscard]] bool network_is_built_in();
/// Why it cannot be on a network without it, and the way out.
[[nodiscard]] Problem network_is_not_built_in(const Place& where);

/// Why there is no security without OpenSSL, and the way out.
[[nodiscard]] Problem security_is_not_built_in(const Place& where);

/// Those of this process that begin with ROS_, RMW_ and CYCLONEDDS_.
[[nodiscard]] transport_dds::Environment ros_environment();

/// Combines launch file and environment, with remarks for the user, also about ports. Reads the files of security as
/// they are at the clock's wall time, and the kernel's range of ports.
/// Errors: as transport_dds::network_settings(); security that must be enforced but cannot be set up, with the file.
[[nodiscard]] Result<transport_dds::NetworkSettings, Problem> network_in_force(
    const launch::NetworkPlan& plan, const transport_dds::Environment& environment, const Clock& clock = SystemClock{});

/// "network: off, although local was asked for: <why>; the robot runs without it".
[[nodiscard]] std::string network_off_line(const Problem& why);

/// mode, because_of, discovery, domain, ports, interfaces, peers, exports, allow_load, remote_control, security, cyclonedds_uri, remarks, line.
[[nodiscard]] nlohmann::json json_of(const transport_dds::NetworkSettings& settings);

}  // namespace nacelle::networking
