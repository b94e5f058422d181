// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"

namespace nacelle::transport_dds {

/// Sees to it that nothing leaves this machine by a UDP socket, and that nothing from elsewhere is read from it, whatever
/// is sent to which address (docs/adr/0014).
///
/// All it sends goes out by lo, where nothing but this machine's own addresses is; what goes to a group there comes to
/// every socket of this machine that is bound to the port, since this side has joined it on lo. A filter in the kernel drops
/// what comes from an address that is neither in 127/8 nor among `own` (IPv4, in the host's order). None of it needs a
/// privilege.
/// Errors: the kernel refuses one of them; the socket must not be used then.
[[nodiscard]] Result<void, Problem> keep_to_this_machine(int socket, const std::vector<std::uint32_t>& own);

/// How a domain was found when it was kept to this machine.
enum class Home : std::uint8_t {
  Alone,
  /// It had heard others before its sockets were ready, who may be of this machine or not, or (on a very busy machine) what
  /// kept it has not ended: it says nothing, and must be ended and made anew.
  Visited
};

/// Keeps all sockets of one of Cyclone's domains to this machine. Right after dds_create_domain(), before its first
/// participant: until this returns it says nothing.
/// `domain`: its handle; `id`: its number. Errors: see above, and a transport other than UDP over IPv4, or sockets that
/// come with each participant. The domain must be ended then.
[[nodiscard]] Result<Home, Problem> keep_domain_to_this_machine(std::int32_t domain, std::uint32_t id);

}  // namespace nacelle::transport_dds
