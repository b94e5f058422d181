// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "broker_topic.hpp"
#include "nacelle/runtime/container.hpp"

namespace nacelle::runtime {

/// Why these two, on one topic, do not talk: one entry per policy, the types if they differ, nothing if they do talk.
[[nodiscard]] std::vector<ClashReport> clashes_between(const EndpointSpec& writer, const EndpointSpec& reader);

/// The same of two types under one name.
[[nodiscard]] ClashReport clash_of_types(const std::string& topic, const std::string& writer_node,
                                         const std::string& writer_type, const std::string& reader_node,
                                         const std::string& reader_type);

/// Two endpoints of a topic see each other for the first time: both note the match, or the clash.
/// Under the topic's lock.
void introduce(BrokerWriter& writer, ReaderQueue& reader);

}  // namespace nacelle::runtime
