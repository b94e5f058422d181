// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "support/recipe.hpp"
#include "topology/graph.hpp"
#include "topology/streams.hpp"

namespace nacelle::bench {

/// One node of a graph as a component.
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

}  // namespace nacelle::bench
