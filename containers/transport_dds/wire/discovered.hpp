// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/wire/dds_qos.hpp"
#include "transport_dds/wire/gid.hpp"

namespace nacelle::transport_dds {

/// A participant as DDS's discovery announces it. The contents are hostile (user_data.hpp).
struct DiscoveredParticipant {
  Gid gid;
  Bytes user_data;
  // From Cyclone's properties __ProcessName, __Hostname and __Pid; empty if they are not announced.
  std::string process;
  std::string host;  ///< Otherwise fastdds.physical_data.host, which Fast DDS announces if it is configured to.
  std::string pid;
};

/// A writer or reader as DDS's discovery announces it.
struct DiscoveredEndpoint {
  Gid gid;
  Gid participant;
  bool is_writer = false;
  std::string topic;  ///< DDS's names; names.hpp converts them to ROS 2's.
  std::string type;
  DdsQos qos;
  Bytes user_data;
};

}  // namespace nacelle::transport_dds
