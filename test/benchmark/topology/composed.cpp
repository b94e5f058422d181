// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <thread>

#include "support/rig.hpp"
#include "topology/node_recipe.hpp"
#include "topology/run.hpp"

namespace nacelle::bench {
namespace {

Tally::Look operator-(const Tally::Look& a, const Tally::Look& b) {
  return {a.published - b.published, a.delivered - b.delivered, a.late - b.late, a.too_late - b.too_late,
          a.lost - b.lost};
}

}  // namespace

Run run_composed(const Graph& graph, Duration measured, Duration patience, bool on_network) {
  Tally tally;
  const auto periods = graph.periods();
  std::deque<NodeRecipe> recipes;
  Rig rig(patience, on_network ? runtime::NodeInterfaces::All : runtime::NodeInterfaces::None);
  for (const auto& node : graph.nodes) rig.add(node.name, recipes.emplace_back(node, periods, tally));
  const auto network = on_network ? go_on_the_network(rig.container()) : nullptr;
  if (on_network && !network) std::fputs("benchmark: this program has no network\n", stderr), std::exit(1);
  std::this_thread::sleep_for(on_network ? 5s : 1s);  // announcements are many in the first seconds
  Run run;
  const Tally::Look before = tally.look();
  run.used = Usage::now();
  std::this_thread::sleep_for(measured);
  run.used = Usage::now() - run.used;
  run.seen = tally.look() - before;
  run.memory = Memory::now();
  run.memory.proportional = own_proportional_memory();
  std::vector<runtime::StreamReport> streams;
  rig.container().report_streams(streams);
  for (const auto& stream : streams) {
    run.copies += stream.copies;
    run.dropped += stream.overwritten + stream.full + stream.would_block;
  }
  return run;
}

}  // namespace nacelle::bench
