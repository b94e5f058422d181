// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/host/transport.hpp"

namespace nacelle {

// Where a law does not hold for every transport: what it is about, and why not. Each has laws of its own in place of it.

/// A reader on a network holds up no publisher (ADR 0012): what is too much for a KEEP_ALL reader is refused and counted there.
template <typename T>
inline constexpr bool kHoldsUp = true;

/// DDS tells a writer's gid and the wall time of a message, of which the reader's side makes an id and a time of its own clock; and
/// Cyclone says which readers get the same bytes.
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
