// SPDX-License-Identifier: Apache-2.0
#include "report/frame_delays.hpp"

#include <algorithm>

namespace nacelle::report {
namespace {

constexpr std::size_t kWindow = 1000;  // tf2_monitor's

/// From a frame to its root; a circle is left where it closes.
std::vector<std::string> way_up(const std::map<std::string, std::string>& parents, std::string frame) {
  std::vector<std::string> way;
  while (std::find(way.begin(), way.end(), frame) == way.end()) {
    way.push_back(frame);
    const auto parent = parents.find(frame);
    if (parent == parents.end()) break;
    frame = parent->second;
  }
  return way;
}

}  // namespace

void FrameDelays::note(const std::string& child, std::int64_t stamp_ns, std::int64_t published_ns) {
  auto& samples = samples_[child];
  samples.push_back({published_ns, static_cast<double>(published_ns - stamp_ns) * 1e-9});
  if (samples.size() > kWindow) samples.pop_front();
}

FrameDelays::Row FrameDelays::of(const std::string& child) const {
  const auto found = samples_.find(child);
  if (found == samples_.end()) return {};
  const auto& samples = found->second;
  Row row;
  row.count = samples.size();
  row.max_delay_s = samples.front().delay_s;
  for (const auto& sample : samples) {
    row.average_delay_s += sample.delay_s / static_cast<double>(samples.size());
    row.max_delay_s = std::max(row.max_delay_s, sample.delay_s);
  }
  const double span_s = static_cast<double>(samples.back().published_ns - samples.front().published_ns) * 1e-9;
  if (span_s > 0) row.rate_hz = static_cast<double>(samples.size() - 1) / span_s;
  return row;
}

FrameDelays::Row FrameDelays::of_all(const std::vector<std::string>& children) const {
  Row all;
  double sum_s = 0;
  for (const auto& child : children) {
    const Row row = of(child);
    if (row.count == 0) continue;
    all.max_delay_s = all.count == 0 ? row.max_delay_s : std::max(all.max_delay_s, row.max_delay_s);
    all.rate_hz = std::max(all.rate_hz, row.rate_hz);
    sum_s += row.average_delay_s * static_cast<double>(row.count);
    all.count += row.count;
  }
  if (all.count != 0) all.average_delay_s = sum_s / static_cast<double>(all.count);
  return all;
}

std::vector<std::string> chain_between(const std::map<std::string, std::string>& parents, const std::string& from,
                                       const std::string& to) {
  std::vector<std::string> chain = way_up(parents, from), down = way_up(parents, to);
  const auto meeting = std::find_first_of(chain.begin(), chain.end(), down.begin(), down.end());
  if (meeting == chain.end()) return {};
  const auto met = std::find(down.begin(), down.end(), *meeting);
  chain.erase(meeting + 1, chain.end());
  chain.insert(chain.end(), std::make_reverse_iterator(met), down.rend());
  return chain;
}

}  // namespace nacelle::report
