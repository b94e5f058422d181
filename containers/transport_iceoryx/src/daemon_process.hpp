// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

// How the daemon is found without iceoryx's help. Source: iceoryx 2.0 (Debian), platform_settings.hpp and iceoryx_posh_types.hpp:
// its socket is /tmp/roudi, and it holds a lock on /tmp/roudi.lock while it lives.
namespace nacelle::transport_iceoryx {

/// errno of connecting to the daemon's socket; 0: a daemon is running. Never waits: it is a datagram socket.
[[nodiscard]] int probe_daemon();

/// A pidfd of the process that holds the daemon's lock; it becomes readable when the process ends. -1: not to be found (another
/// PID namespace, no /proc). Ownership: the caller's.
[[nodiscard]] int open_daemon_process();

/// The process that /proc/locks says holds the lock on a file; 0: none.
[[nodiscard]] int holder_of(const std::string& locks, unsigned long inode, unsigned device_major,
                            unsigned device_minor);

}  // namespace nacelle::transport_iceoryx
