// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "broker_topic.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// Returns why these two endpoints of a topic are incompatible: one entry per policy, the types if they differ; empty
/// if they are compatible.
[[nodiscard]] std::vector<ClashReport> clashes_between(const EndpointSpec& writer, const EndpointSpec& reader);

/// The same for two types under one name.
[[nodiscard]] ClashReport clash_of_types(const std::string& topic, const std::string& writer_node,
                                         const std::string& writer_type, const std::string& reader_node,
                                         const std::string& reader_type);

/// Records the match, or the clash, of two endpoints of a topic at both of them. Under the topic's lock.
void introduce(BrokerWriter& writer, ReaderQueue& reader);

}  // namespace nacelle::runtime
