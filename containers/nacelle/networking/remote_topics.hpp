// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nacelle/node/network_facts.hpp"

namespace nacelle::transport_dds {
class RemoteGraph;
}

namespace nacelle::networking {

/// Returns what other participants publish, by name, type and hash.
[[nodiscard]] std::vector<RemoteTopic> remote_topics_of(const transport_dds::RemoteGraph& graph);

}  // namespace nacelle::networking
