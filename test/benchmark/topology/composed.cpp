// SPDX-License-Identifier: Apache-2.0
#include <deque>
#include <thread>

#include "support/rig.hpp"
#include "topology/run.hpp"

namespace nacelle::bench {
namespace {

class NodeRecipe final : public Recipe {
 public:
  NodeRecipe(const GraphNode& node, const std::map<std::string, Duration>& periods, Tally& tally)
      : node_(node), tally_(tally) {
    for (const auto& sink : node.sinks) {
      const auto found = periods.find(sink.topic);
      states_.push_back({&tally, &clock_, found == periods.end() ? Duration{1s} : found->second});
    }
  }
  std::shared_ptr<void> build(LifecycleNode& node) override {
    auto made = std::make_shared<std::vector<std::shared_ptr<void>>>();
    for (std::size_t i = 0; i < node_.sinks.size(); ++i) {
      made->push_back(stream_type(node_.sinks[i].type).make_sink(node, node_.sinks[i], states_[i]));
    }
    for (const auto& source : node_.sources)
      made->push_back(stream_type(source.type).make_source(node, source, tally_));
    return made;
  }

 private:
  const GraphNode& node_;
  Tally& tally_;
  const SystemClock clock_;
  std::deque<ReaderState> states_;
};

Tally::Look operator-(const Tally::Look& a, const Tally::Look& b) {
  return {a.published - b.published, a.delivered - b.delivered, a.late - b.late, a.too_late - b.too_late,
          a.lost - b.lost};
}

}  // namespace

Run run_composed(const Graph& graph, Duration measured, Duration patience) {
  Tally tally;
  const auto periods = graph.periods();
  std::deque<NodeRecipe> recipes;
  Rig rig(patience);
  for (const auto& node : graph.nodes) rig.add(node.name, recipes.emplace_back(node, periods, tally));
  std::this_thread::sleep_for(1s);
  Run run;
  const Tally::Look before = tally.look();
  run.used = Usage::now();
  std::this_thread::sleep_for(measured);
  run.used = Usage::now() - run.used;
  run.seen = tally.look() - before;
  run.memory = Memory::now();
  std::vector<runtime::StreamReport> streams;
  rig.container().report_streams(streams);
  for (const auto& stream : streams) {
    run.copies += stream.copies;
    run.dropped += stream.overwritten + stream.full + stream.would_block;
  }
  return run;
}

}  // namespace nacelle::bench
