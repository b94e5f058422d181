// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle {

// What may name a place on a network, in a launch file and in ROS 2's variables. Pure. Threads: call from anywhere.
// Errors: a Problem whose `where` is empty; the caller knows it.

inline constexpr int kMostDomain = 232;  ///< DDS: the ports of a higher domain would be above 65535.
inline constexpr std::size_t kMostPeerBytes = 255;
inline constexpr std::size_t kMostInterfaceBytes = 45;  ///< An IPv6 address; a name has 15.

/// A host name, an IPv4 or IPv6 address, with or without a port: what may stand in Cyclone's list of peers.
[[nodiscard]] Result<void, Problem> validate_peer(std::string_view peer);
/// The name of an interface ("eth0", "wlan0.5", "veth@if3"), or an address of this machine.
[[nodiscard]] Result<void, Problem> validate_interface(std::string_view name);
/// 0 to kMostDomain.
[[nodiscard]] Result<void, Problem> validate_domain(long long domain);

}  // namespace nacelle
