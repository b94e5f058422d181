// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "transport_dds/port/cyclone.hpp"

namespace nacelle::transport_dds {

/// Ends a writer or reader, and frees its announcement.
///
/// Cyclone announces an endpoint to other participants as a sample, keyed by the endpoint's gid. When the endpoint
/// ends, the history of these samples does not release its reference to the key, which is a copy of the whole
/// announcement (topic, type, QoS, user data). Cyclone 0.10 keeps it until the domain ends: 0.4 to 0.5 KB per endpoint
/// of ROS 2's (ADR 0020). If Cyclone has released it, this function finds nothing to free.
/// Source: free_one_instance_from_idx() in dds_whc.c of 0.10.2 and 0.10.5; eclipse-cyclonedds/cyclonedds issue 1487.
/// `type` is registered with the endpoint's domain. Blocks as dds_delete() does.
void end_endpoint(Entity& endpoint, const Gid& gid, const ddsi_sertype& type) noexcept;

}  // namespace nacelle::transport_dds
