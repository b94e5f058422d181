// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nacelle/base/problem.hpp"
#include "nacelle/base/result.hpp"
#include "transport_dds/port/endpoint.hpp"
#include "transport_dds/wire/gid.hpp"
#include "transport_dds/wire/security_files.hpp"

namespace nacelle::transport_dds {

struct ParticipantCore;
class Discovery;
class DiscoveryListener;
class Reader;
class Writer;

struct ParticipantOptions {
  std::uint32_t domain_id = 0;
  /// Cyclone's configuration as XML: fragments (`<General>...</General>`), joined by commas; later ones take
  /// precedence. The environment is ignored.
  std::string config;
  /// Nothing is sent to or received from other machines, whatever the configuration says.
  bool stays_on_this_machine = false;
  Bytes user_data;                                          ///< "enclave=/;"
  std::size_t most_message_bytes = std::size_t{64} << 20U;  ///< Longer ones are refused and counted, both ways.
  /// Limit for all messages of one type that wait or are being sent; messages beyond it are refused and counted.
  std::size_t most_bytes_of_type = std::size_t{256} << 20U;
  /// A trial participant only tests the options: it neither sends nor receives.
  bool is_trial = false;
  /// Nothing: traffic is unsecured. Otherwise only participants with a certificate of the same authority can read and
  /// send.
  std::optional<SecurityFiles> security;
};

/// A container on the network: Cyclone DDS with all its threads and sockets. One per domain and process.
///
/// Whatever the configuration says, Cyclone's shared memory is off (it loses data silently and ends the process when
/// its daemon is missing), and a writer with KEEP_LAST never waits for a slow reader, which may fall behind by the
/// writer's history.
/// Ownership: the domain exists until this object and all endpoints made by it are destroyed.
/// Threads: any.
class Participant {
 public:
  /// Joins a domain. Errors: a configuration that Cyclone cannot read, no such interface, no free participant index, a
  /// domain that this process has joined already; a kernel or transport that cannot be restricted to this machine;
  /// files of DDS Security that its plugins refuse.
  [[nodiscard]] static Result<std::unique_ptr<Participant>, Problem> create(const ParticipantOptions& options);
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  ~Participant();

  [[nodiscard]] Gid gid() const;
  /// Returns the settings that could not be applied: peers without an address.
  [[nodiscard]] std::vector<Problem> remarks() const;
  /// `listener` must outlive the endpoint; null: no listener. Errors: a name or QoS that Cyclone refuses.
  [[nodiscard]] Result<std::unique_ptr<Writer>, Problem> create_writer(const EndpointOptions& options,
                                                                       EndpointListener* listener);
  [[nodiscard]] Result<std::unique_ptr<Reader>, Problem> create_reader(const EndpointOptions& options,
                                                                       EndpointListener* listener);
  [[nodiscard]] Result<std::unique_ptr<Discovery>, Problem> create_discovery(DiscoveryListener* listener);
  /// While muted, the participant sends nothing, and no thread waits for the network. Used to abort the transfer of a
  /// long message.
  void set_mute(bool mute);

 private:
  explicit Participant(std::shared_ptr<ParticipantCore> core);
  std::shared_ptr<ParticipantCore> core_;
};

}  // namespace nacelle::transport_dds
