// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "nacelle/base/time.hpp"

namespace nacelle::bench {

/// Publishes one message of `bytes` payload every `period`.
struct Source {
  std::string topic, type;
  Duration period{};
  std::size_t bytes = 0;
  bool filled = false;  ///< The whole payload is written for each message, as a driver would.
};
struct Sink {
  std::string topic, type;
};
struct GraphNode {
  std::string name;
  std::vector<Source> sources;
  std::vector<Sink> sinks;
};

/// A publish/subscribe graph; bench.py writes it from data/topologies. Lines of words:
///
///     node NAME
///     pub TOPIC TYPE PERIOD_US BYTES as_is|filled
///     sub TOPIC TYPE
struct Graph {
  std::vector<GraphNode> nodes;
  [[nodiscard]] std::map<std::string, Duration> periods() const;
  /// Messages per second that timers ask for, and those times their readers.
  [[nodiscard]] double offered_hz() const;
  [[nodiscard]] double deliveries_hz() const;
};

/// Errors: a file or a line that cannot be read ends the program with code 2.
[[nodiscard]] Graph read_graph(const std::string& file);

}  // namespace nacelle::bench
