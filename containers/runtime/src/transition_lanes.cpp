// SPDX-License-Identifier: Apache-2.0
#include "transition_lanes.hpp"

#include <system_error>
#include <utility>
#include <vector>

namespace nacelle::runtime {

TransitionLanes::~TransitionLanes() {
  std::vector<std::unique_ptr<Errand>> running;
  {
    auto lanes = lanes_.lock();
    for (auto& [node, lane] : *lanes) {
      lane.waiting.clear();
      running.push_back(std::move(lane.errand));
    }
  }
  running.clear();  // without the lock, which they take
}

bool TransitionLanes::push(std::uint64_t node, std::function<void()> job) {
  auto lanes = lanes_.lock();
  sweep(*lanes);
  Lane& lane = (*lanes)[node];
  if (lane.waiting.size() >= kMostWaiting) return false;
  lane.waiting.push_back(std::move(job));
  if (lane.busy) return true;
  // The last errand, if there was one, only has to end.
  try {
    lane.errand = std::make_unique<Errand>("transition", [this, &lane] { work(lane); });
  } catch (const std::system_error&) {
    lane.waiting.pop_back();
    return false;  // no thread can be started: refused as if too many were waiting
  }
  lane.busy = true;
  return true;
}

void TransitionLanes::drop(std::uint64_t node) {
  auto lanes = lanes_.lock();
  if (const auto found = lanes->find(node); found != lanes->end()) found->second.waiting.clear();
  sweep(*lanes);
}

void TransitionLanes::sweep(Lanes& lanes) {
  std::erase_if(lanes, [](const auto& entry) { return !entry.second.busy; });
}

void TransitionLanes::work(Lane& lane) {
  for (;;) {
    std::function<void()> job;
    {
      const auto lanes = lanes_.lock();
      if (lane.waiting.empty()) {
        lane.busy = false;
        return;
      }
      job = std::move(lane.waiting.front());
      lane.waiting.pop_front();
    }
    job();
  }
}

}  // namespace nacelle::runtime
