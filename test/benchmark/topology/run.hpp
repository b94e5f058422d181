// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nacelle/runtime/container.hpp"
#include "support/usage.hpp"
#include "topology/graph.hpp"
#include "topology/streams.hpp"

namespace nacelle::bench {

/// What a graph has done and used in the measured time, after one second of warming up.
struct Run {
  Tally::Look seen;
  Usage used;
  Memory memory;              ///< At the end.
  std::uint64_t copies = 0;   ///< Of the whole run, from the container's stream counters.
  std::uint64_t dropped = 0;  ///< Overwritten or refused in queues, of the whole run.
};

/// Shows the container's nodes on a network without other participants, for as long as the result lives. In the program
/// without a network (`topology`, whose memory is what a robot without DDS takes) null: there is none.
[[nodiscard]] std::shared_ptr<void> go_on_the_network(runtime::Container& container);

/// The graph as components of one container, all on the shared executor. `patience`: see Rig. `on_network`: each node has the
/// services of a ROS 2 node, too. Errors: on a network that is not there, the program ends with code 1.
[[nodiscard]] Run run_composed(const Graph& graph, Duration measured, Duration patience, bool on_network);
/// Each node as a component of a process of its own, joined by links over the process that measures: the shape of
/// `isolate: process` for every component. Usage and memory are sums over all processes.
[[nodiscard]] Run run_apart(const Graph& graph, Duration measured);
/// Bytes of this process in memory, shared pages in parts (PSS).
[[nodiscard]] std::uint64_t own_proportional_memory();
/// The same callbacks from one thread that sleeps with clock_nanosleep until the next timer is due; timers of one period are
/// aligned, which is the least that the work can cost.
[[nodiscard]] Run run_bare(const Graph& graph, Duration measured);

}  // namespace nacelle::bench
