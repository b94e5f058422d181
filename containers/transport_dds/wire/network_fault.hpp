// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace nacelle::transport_dds {

/// What is wrong with the network.
enum class NetworkFault : std::uint8_t {
  EndNotShown,  ///< An endpoint of this side could not be made; Problem::value is its topic or service.
  ServiceUnusable,  ///< Calls of a service fail: another type or protocol at its other end, a request that is too long; as before.
  InterfaceTwice,      ///< Cyclone was given one interface by two names.
  NoParticipantIndex,  ///< No port is free for one more participant of this domain on this machine.
  NoSuchInterface,     ///< An interface that is not there, or has no address.
  BadConfiguration,    ///< Cyclone refuses its configuration.
  DomainInUse,         ///< This process has a participant in this domain already.
  WrongSetting,        ///< A key of `network:` or a variable of ROS 2 cannot have this value, which is Problem::value.
  Overruled,           ///< The launch file sets another value than this variable of ROS 2, and is in force (a remark).
  PeersUnused,         ///< Peers are set, and the mode asks none (a remark).
  ConfigurationTaken,  ///< CYCLONEDDS_URI takes precedence over the settings shown (a remark).
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
