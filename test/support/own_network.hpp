// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nacelle::test {

/// Puts this process into a network of its own, in which there is nothing but a loopback interface: what other tests,
/// robots and machines send does not come here. It gets an empty /dev/shm as well, which ends with it. Processes and
/// threads that are started afterwards are in it, too. Call it before there are threads. Errors: false where the kernel
/// does not allow it; then everything stays as it was.
[[nodiscard]] bool enter_own_network();

/// Gives lo of this process's own network one more address ("10.9.9.1"). Errors: false without such a network.
[[nodiscard]] bool add_to_loopback(const char* address);

/// Gives this process's own network an empty LAN: an interface with this address and 24 bits of network, that carries
/// multicast. Errors: false without such a network, or without iproute2.
[[nodiscard]] bool add_lan(const char* address);

}  // namespace nacelle::test
