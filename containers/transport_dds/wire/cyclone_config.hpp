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

/// Highest index of a participant on one machine. The index determines its UDP ports. A peer that is given without a
/// port is contacted at the ports of all indices, so both sides must use the same limit; this is rmw_cyclonedds'.
inline constexpr int kMostParticipantIndex = 32;

/// Returns the argument of dds_create_domain(): Nacelle's settings, then those of CYCLONEDDS_URI, separated by ',' as
/// Cyclone requires.
/// Precondition: the mode is not Off.
/// Source: check_create_domain of rmw_node.cpp (jazzy) for Unicast; docs/manual/options.md of Cyclone 0.10.
[[nodiscard]] std::string cyclone_config(const NetworkSettings& settings);

/// UDP ports, both ends included.
struct PortRange {
  int first = 0;
  int last = 0;
};
/// Returns the UDP ports that a domain may use: multicast, and those of participants up to `most_index`.
/// Source: OMG DDSI-RTPS 2.3 section 9.6.1.1: 7400 + 250 * domain; + 0, 1 multicast; + 10, 11 + 2 * index.
[[nodiscard]] PortRange ports_of_domain(int domain, int most_index = kMostParticipantIndex);
/// Parses "8080,9000-9010", the format of the kernel's net.ipv4.ip_local_reserved_ports. Ignores invalid ports.
[[nodiscard]] std::vector<PortRange> parse_port_ranges(std::string_view text);
/// Returns a warning if the kernel may assign one of the domain's ports to any program. `ephemeral` is
/// net.ipv4.ip_local_port_range; the kernel does not assign those in `reserved`.
[[nodiscard]] std::optional<Problem> port_remark(int domain, const PortRange& ephemeral,
                                                 const std::vector<PortRange>& reserved = {});

}  // namespace nacelle::transport_dds
