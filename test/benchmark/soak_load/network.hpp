// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "nacelle/runtime/container.hpp"

namespace nacelle::soak {

/// Shows a container on the loopback interface, with other participants that see all of its endpoints and read two of its
/// topics.
class SoakNetwork {
 public:
  /// Puts this process into a network of its own where the kernel allows it. Call it before there are threads.
  static void enter();
  /// Errors: ends the program with the reason.
  SoakNetwork(runtime::Container& container, const Clock& clock, std::size_t peers);
  ~SoakNetwork();

  enum class With : std::uint8_t { Neighbour, Both };
  /// Returns when the container and all peers have seen the endpoints that belong to this composition. The first call of each
  /// finds out how many these are: it returns when their number has not changed for half a second.
  void await(With composition);
  /// Endpoints of the container with this composition: two for each server and client, one for each topic's end.
  [[nodiscard]] std::size_t endpoints(With composition) const;

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::soak
