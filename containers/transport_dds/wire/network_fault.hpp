// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::transport_dds {

/// Faults and warnings of the network.
enum class NetworkFault : std::uint8_t {
  EndNotShown,  ///< An endpoint of this side could not be made; Problem::value is its topic or service.
  /// Calls of a service fail: the peer uses another type or protocol, a message is too long or invalid, too many calls
  /// wait, or the server's node is not active. Problem::value is the service.
  ServiceUnusable,
  InterfaceTwice,      ///< The configuration names one interface twice.
  NoParticipantIndex,  ///< All participant indices of this domain are in use on this machine.
  NoSuchInterface,     ///< An interface does not exist or has no address.
  BadConfiguration,    ///< Cyclone refuses its configuration.
  DomainInUse,         ///< This process already has a participant in this domain.
  WrongSetting,  ///< Invalid value of a key of `network:` or of a variable of ROS 2; Problem::value is that value.
  Overruled,     ///< Warning: the launch file overrides this variable of ROS 2; Problem::value is the variable's value.
  PeersUnused,   ///< Warning: peers are set, but this mode contacts none; Problem::value lists them.
  ConfigurationTaken,  ///< Warning: CYCLONEDDS_URI overrides the settings shown; Problem::value is its value.
};
[[nodiscard]] constexpr const char* code_text(NetworkFault fault) {
  switch (fault) {
    case NetworkFault::EndNotShown: return "network.end_not_shown";
    case NetworkFault::ServiceUnusable: return "network.service_unusable";
    case NetworkFault::InterfaceTwice: return "network.interface_twice";
    case NetworkFault::NoParticipantIndex: return "network.no_participant_index";
    case NetworkFault::NoSuchInterface: return "network.no_such_interface";
    case NetworkFault::BadConfiguration: return "network.bad_configuration";
    case NetworkFault::DomainInUse: return "network.domain_in_use";
    case NetworkFault::WrongSetting: return "network.wrong_setting";
    case NetworkFault::Overruled: return "network.overruled";
    case NetworkFault::PeersUnused: return "network.peers_unused";
    case NetworkFault::ConfigurationTaken: return "network.configuration_taken";
  }
  return "";
}

}  // namespace nacelle::transport_dds
