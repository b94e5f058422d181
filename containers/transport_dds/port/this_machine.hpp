// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::transport_dds {

/// Restricts a UDP socket so that nothing leaves this machine through it and nothing from other machines is read from
/// it, whatever the addresses (docs/adr/0014).
///
/// All packets are sent through lo, which reaches only this machine's own addresses. Multicasts on lo reach every
/// socket of this machine that is bound to the port, because this side has joined the group on lo. A filter in the
/// kernel drops packets from an address that is neither in 127/8 nor among `own` (IPv4, in the host's order). No
/// privilege is required.
/// Errors: the kernel refuses a setting. Then the socket must not be used.
[[nodiscard]] Result<void, Problem> keep_to_this_machine(int socket, const std::vector<std::uint32_t>& own);

/// The state of a domain when it was restricted to this machine.
enum class Home : std::uint8_t {
  Alone,
  /// It has discovered a participant of this machine or another before its sockets were restricted, or (under high
  /// load) the restriction has not finished. It sends nothing, and must be destroyed and made again.
  Visited
};

/// Restricts all sockets of one of Cyclone's domains to this machine. Call right after dds_create_domain(), before its
/// first participant is made: the domain sends nothing until this returns. `domain`: its handle; `id`: its number.
/// Errors: as above; a transport other than UDP over IPv4; sockets of each participant's own. Then the domain must be
/// destroyed.
[[nodiscard]] Result<Home, Problem> keep_domain_to_this_machine(std::int32_t domain, std::uint32_t id);

}  // namespace nacelle::transport_dds
