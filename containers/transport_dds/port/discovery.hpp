// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <variant>
#include <vector>

#include "transport_dds/port/participant.hpp"
#include "transport_dds/wire/discovered.hpp"

namespace nacelle::transport_dds {

/// A change of a participant or an endpoint on the network, including those of this process.
struct DiscoveryEvent {
  enum class Kind : std::uint8_t {
    Appeared,
    Changed,  ///< Announced again, possibly with another QoS or user data.
    Gone,     ///< Ended, or its participant's lease has expired. Only the gids and is_writer are set.
  } kind = Kind::Appeared;
  std::variant<DiscoveredParticipant, DiscoveredEndpoint> what;
};

/// Called when take() has events. Threads and rules: as EndpointListener.
class DiscoveryListener {
 public:
  virtual ~DiscoveryListener() = default;
  virtual void on_discovery() noexcept = 0;
};

/// The participants, writers and readers that Cyclone knows of (DDS's builtin topics).
///
/// The queue is Cyclone's own list, with one entry for each entity, so it grows with the network. An entity that
/// appeared and disappeared between two calls is reported as Gone without an Appeared, or not at all.
/// Threads: take() one at a time.
class Discovery {
 public:
  /// Used by Participant::create_discovery().
  [[nodiscard]] static Result<std::unique_ptr<Discovery>, Problem> create(std::shared_ptr<ParticipantCore> core,
                                                                          DiscoveryListener* listener);
  Discovery(const Discovery&) = delete;
  Discovery& operator=(const Discovery&) = delete;
  ~Discovery();

  /// Appends at most `most` events to `out`: participants before writers before readers. Returns true if there may be
  /// more.
  [[nodiscard]] bool take(std::vector<DiscoveryEvent>& out, std::size_t most);

 private:
  struct Impl;
  explicit Discovery(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace nacelle::transport_dds
