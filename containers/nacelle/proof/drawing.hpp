// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nacelle/proof/declared_graph.hpp"

namespace nacelle::proof {

/// The pipeline as nodes and topics, with the QoS of each end on its edge. Ends that do not fit (`bad` holds
/// "topic node") are red.
struct Drawing {
  struct Vertex {
    std::string name, detail;  ///< detail: a topic's type
    bool is_topic = false;
    int column = 0;  ///< From the sources on the left; what flows in a circle is cut at one place.
  };
  struct Edge {
    std::size_t from = 0, to = 0;
    std::string label;  ///< "keep_last 10, reliable, volatile"
    bool bad = false;
  };
  std::vector<Vertex> vertices;
  std::vector<Edge> edges;
};

/// Pure; the same endpoints give the same drawing.
[[nodiscard]] Drawing draw(const std::vector<Endpoint>& endpoints, const std::vector<std::string>& bad = {});
/// For graphviz.
[[nodiscard]] std::string to_dot(const Drawing& drawing);
/// Complete, with a layout of its own: one column per step of the pipeline; a node's box lists the ends of its streams, a hollow
/// dot is an end without another one.
[[nodiscard]] std::string to_svg(const Drawing& drawing);

}  // namespace nacelle::proof
