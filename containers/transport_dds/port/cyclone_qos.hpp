// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/base/bytes.hpp"
#include "transport_dds/port/cyclone.hpp"
#include "transport_dds/wire/dds_qos.hpp"
#include "transport_dds/wire/discovered.hpp"

namespace nacelle::transport_dds {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using CycloneQos = std::unique_ptr<dds_qos_t, QosDeleter>;

/// Returns the QoS that rmw_cyclonedds sets for its endpoints: the policies of `qos`, and XCDR1 only.
[[nodiscard]] CycloneQos to_cyclone(const DdsQos& qos, ByteView user_data, bool is_writer);

/// Longer user data of discovered endpoints and participants is dropped. ROS 2's has about 200 bytes.
inline constexpr std::size_t kMostUserData = 4096;
[[nodiscard]] DiscoveredEndpoint to_endpoint(const dds_builtintopic_endpoint_t& found, bool is_writer);
[[nodiscard]] DiscoveredParticipant to_participant(const dds_builtintopic_participant_t& found);

}  // namespace nacelle::transport_dds
