// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/host/graph.hpp"
#include "nacelle/qos/qos.hpp"

namespace nacelle::proof {

/// One publisher or subscription as its node declared it, with the QoS that the launch file made of it.
struct Endpoint {
  std::string node, topic, type;
  bool publishes = false;
  QoS qos{10};
  bool is_command = false;  ///< A reader that stops something when the messages stop.
  bool is_apart = false;    ///< Of another process: what its code says of it beside the QoS is not known here.
};

/// Every endpoint of a graph, but for those of tools; by topic, publishers first, then by node. Threads: any.
[[nodiscard]] std::vector<Endpoint> endpoints_of(Graph& graph);

}  // namespace nacelle::proof
