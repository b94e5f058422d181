// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "proof/declared_graph.hpp"

namespace nacelle::proof {

/// Returns the pipeline in the DOT language: a box for each node with its endpoints and their QoS, subscriptions above
/// publishers, and an edge from each publisher to each subscription of its topic.
///
/// An action is drawn as one endpoint. An endpoint without a counterpart is grey. An endpoint in `bad`, as "topic
/// node", is red. Pure: the same endpoints give the same text.
[[nodiscard]] std::string to_dot(const std::vector<Endpoint>& endpoints, const std::vector<std::string>& bad = {});

}  // namespace nacelle::proof
