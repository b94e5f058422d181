// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "transport_dds/wire/network_settings.hpp"

namespace nacelle::transport_dds {

/// Without multicast each process of a machine takes a number from 0 to this one, and its ports; a peer is asked on all
/// of them. rmw_cyclonedds' number: both sides must have the same.
inline constexpr int kMostParticipantIndex = 32;

/// The argument of dds_create_domain(): Nacelle's settings, then CYCLONEDDS_URI's, separated by ',' as Cyclone
/// requires.
/// Precondition: the mode is not Off.
/// Source: check_create_domain of rmw_node.cpp (jazzy) for Unicast; docs/manual/options.md of Cyclone 0.10.
[[nodiscard]] std::string cyclone_config(const NetworkSettings& settings);

/// UDP ports, both ends included.
struct PortRange {
  int first = 0;
  int last = 0;
};
/// Those that a domain may use: multicast, and those of participants up to `most_index`.
/// Source: OMG DDSI-RTPS 2.3 section 9.6.1.1: 7400 + 250 * domain; + 0, 1 multicast; + 10, 11 + 2 * index.
[[nodiscard]] PortRange ports_of_domain(int domain, int most_index = kMostParticipantIndex);
/// "8080,9000-9010", as the kernel writes net.ipv4.ip_local_reserved_ports; invalid ports are ignored.
[[nodiscard]] std::vector<PortRange> parse_port_ranges(std::string_view text);
/// Returns a warning if the kernel may have given one of these ports to another program. `ephemeral` is
/// net.ipv4.ip_local_port_range; the kernel never gives away those in `reserved`.
[[nodiscard]] std::optional<Problem> port_remark(int domain, const PortRange& ephemeral,
                                                 const std::vector<PortRange>& reserved = {});

}  // namespace nacelle::transport_dds
