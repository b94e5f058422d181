// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "proof/declared_graph.hpp"

namespace nacelle::proof {

/// Returns the pipeline in the DOT language: a box for each node with the ends of its streams and their QoS, what it reads above
/// what it publishes, and an edge from each publisher to each subscription of its topic.
///
/// An action is one end. An end that meets no other one is grey; ends that do not fit (`bad` holds "topic node") are red.
/// Pure; the same endpoints give the same text.
[[nodiscard]] std::string to_dot(const std::vector<Endpoint>& endpoints, const std::vector<std::string>& bad = {});

}  // namespace nacelle::proof
