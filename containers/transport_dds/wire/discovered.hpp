// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/wire/dds_qos.hpp"
#include "transport_dds/wire/gid.hpp"

namespace nacelle::transport_dds {

/// A participant as DDS's discovery announces it: hostile until it has been read (user_data.hpp).
struct DiscoveredParticipant {
  Gid gid;
  Bytes user_data;
  std::string process;  ///< The properties __ProcessName, __Hostname and __Pid, which Cyclone announces; else empty.
                        ///< Fast DDS announces the host as fastdds.physical_data.host, if it was asked to.
  std::string host;
  std::string pid;
};

/// A writer or reader as DDS's discovery announces it.
struct DiscoveredEndpoint {
  Gid gid;
  Gid participant;
  bool is_writer = false;
  std::string topic;  ///< DDS's names: names.hpp makes ROS 2's of them.
  std::string type;
  DdsQos qos;
  Bytes user_data;
};

}  // namespace nacelle::transport_dds
