// SPDX-License-Identifier: Apache-2.0
#include "fault_history.hpp"

#include <algorithm>

#include "nacelle/base/reversed.hpp"

namespace nacelle::runtime {

void FaultHistory::add(FaultEvent event) {
  event.number = facts_->faults.fetch_add(1) + 1;
  auto& mine = of_[event.node];
  mine.push_back(std::move(event));
  if (mine.size() > kPerNode) mine.pop_front();
  if (of_.size() <= kNodes) return;
  // Callers may use a new name for every load, so the number of nodes is limited: the one whose last fault is oldest is
  // removed.
  of_.erase(std::ranges::min_element(of_, {}, [](const auto& entry) { return entry.second.back().number; }));
}

void FaultHistory::end(const std::string& node, const std::string& code, Duration lasted) {
  const auto found = of_.find(node);
  if (found == of_.end()) return;
  for (auto& event : reversed(found->second)) {
    if (!event.is_open_fault || event.lasted || event.code != code) continue;
    event.lasted = lasted;
    return;
  }
}

std::vector<FaultEvent> FaultHistory::all() const {
  std::vector<FaultEvent> events;
  for (const auto& [node, mine] : of_) events.insert(events.end(), mine.begin(), mine.end());
  std::ranges::sort(events, {}, &FaultEvent::number);
  return events;
}

}  // namespace nacelle::runtime
