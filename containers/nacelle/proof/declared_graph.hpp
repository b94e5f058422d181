// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/host/graph.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::proof {

/// One publisher or subscription as its node declared it, with the launch file's QoS applied.
struct Endpoint {
  std::string node, topic, type;
  bool publishes = false;
  QoS qos{10};
  bool is_command = false;  ///< A reader with a command timeout.
  bool is_apart = false;    ///< In another process; of its code only the QoS is known here.
};

/// Returns every endpoint of a graph except those of tools, sorted by topic, publishers first, then by node. Threads:
/// any.
[[nodiscard]] std::vector<Endpoint> endpoints_of(Graph& graph);

}  // namespace nacelle::proof
