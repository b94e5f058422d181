// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/host/transport.hpp"

namespace nacelle {

// Laws that do not hold for every transport, with the reason. A transport without such a law has laws of its own instead.

/// A reader on a network holds up no publisher (ADR 0012): what is too much for a KEEP_ALL reader is refused and counted there.
template <typename T>
inline constexpr bool kHoldsUp = true;

/// DDS passes a writer's gid and a message's wall time, which the reader's side converts into an id and a time of its own clock.
/// Cyclone reports which readers get the same bytes.
template <typename T>
inline constexpr bool kTellsInfo = true;

/// A transport that is chosen at run time.
struct NamedTransport {
  const char* name;
  std::unique_ptr<Transport> (*make)(const Clock& clock);
};
template <typename T>
std::unique_ptr<Transport> make_transport(const Clock& clock) {
  return std::make_unique<T>(clock);
}

}  // namespace nacelle
