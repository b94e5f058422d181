// SPDX-License-Identifier: Apache-2.0
#include "session/restarts.hpp"

namespace nacelle::session {

std::optional<MonotonicTime> Restarts::on_fault(const std::string& node, const FaultHandling& handling,
                                                MonotonicTime now) {
  Entry& entry = of_[node];
  if (entry.due) return entry.due;  // one is on its way
  if (entry.last && now - *entry.last > kWell) entry.count = 0;
  if (entry.count >= handling.max_restarts) return std::nullopt;
  ++entry.count;
  entry.due = now + handling.backoff;
  return entry.due;
}

std::vector<std::string> Restarts::take_due(MonotonicTime now) {
  std::vector<std::string> nodes;
  for (auto& [node, entry] : of_) {
    if (!entry.due || *entry.due > now) continue;
    entry.due.reset();
    entry.last = now;
    nodes.push_back(node);
  }
  return nodes;
}

std::optional<MonotonicTime> Restarts::next_due() const {
  std::optional<MonotonicTime> next;
  for (const auto& [node, entry] : of_) {
    if (entry.due && (!next || *entry.due < *next)) next = entry.due;
  }
  return next;
}

std::optional<MonotonicTime> Restarts::due_of(const std::string& node) const {
  const auto found = of_.find(node);
  return found == of_.end() ? std::nullopt : found->second.due;
}

std::uint32_t Restarts::count_of(const std::string& node) const {
  const auto found = of_.find(node);
  return found == of_.end() ? 0 : found->second.count;
}

}  // namespace nacelle::session
