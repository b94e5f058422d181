// SPDX-License-Identifier: Apache-2.0
// topology graph=FILE [seconds=10] [bare=0] [apart=0] [patience=0] [network=0]
// Runs a publish/subscribe graph in one container (or without any, or with a process for each node) and prints what it did and
// used.
#include "support/arguments.hpp"
#include "topology/run.hpp"

int main(int count, char** words) {
  using namespace nacelle;
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  const bench::Graph graph = read_graph(arguments.text("graph", ""));
  const Duration measured = std::chrono::seconds(arguments.number("seconds", 10));
  const Run run = arguments.number("bare", 0) != 0 ? run_bare(graph, measured)
                  : arguments.number("apart", 0) != 0
                      ? run_apart(graph, measured)
                      : run_composed(graph, measured, std::chrono::seconds(arguments.number("patience", 0)),
                                     arguments.number("network", 0) != 0);
  const auto figure = [](auto value) { return static_cast<double>(value); };
  const double seconds = to_seconds(run.used.at.since_origin);
  print_figures({{"seconds", seconds},
                 {"offered", graph.offered_hz() * seconds},
                 {"expected", graph.deliveries_hz() * seconds},
                 {"published", figure(run.seen.published)},
                 {"delivered", figure(run.seen.delivered)},
                 {"late", figure(run.seen.late)},
                 {"too_late", figure(run.seen.too_late)},
                 {"lost", figure(run.seen.lost)},
                 {"dropped", figure(run.dropped)},
                 {"copies", figure(run.copies)},
                 {"mallocs", figure(run.used.mallocs)},
                 {"faults", figure(run.used.faults)},
                 {"switches", figure(run.used.switches)},
                 {"cpu_s", to_seconds(run.used.cpu)},
                 {"rss", figure(run.memory.resident)},
                 {"pss", figure(run.memory.proportional)},
                 {"rss_anon", figure(run.memory.anonymous)}});
  return 0;
}
