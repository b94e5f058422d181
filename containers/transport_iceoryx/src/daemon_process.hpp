// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

// Finds the daemon's process without calling iceoryx. The daemon's socket is /tmp/roudi, and it holds a lock on
// /tmp/roudi.lock while it runs. Source: iceoryx 2.0 (Debian), platform_settings.hpp and iceoryx_posh_types.hpp.
namespace nacelle::transport_iceoryx {

/// Tries to connect to the daemon's socket. Returns 0 if a daemon runs, else errno. Does not block: it is a datagram
/// socket.
[[nodiscard]] int probe_daemon();

/// Returns a pidfd of the process that holds the daemon's lock; it becomes readable when the process ends. Returns -1
/// if the process cannot be found (another PID namespace, no /proc). Ownership: the caller closes it.
[[nodiscard]] int open_daemon_process();

/// Returns the process that holds the lock on a file, according to `locks`, the text of /proc/locks; 0: none.
[[nodiscard]] int holder_of(const std::string& locks, unsigned long inode, unsigned device_major,
                            unsigned device_minor);

}  // namespace nacelle::transport_iceoryx
