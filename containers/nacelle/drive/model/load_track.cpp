// SPDX-License-Identifier: Apache-2.0
#include "drive/model/load_track.hpp"

#include <algorithm>

namespace nacelle::drive {
namespace {

using run_page::Sample;

constexpr double kCpuWindow_s = 1.0, kRateWindow_s = 2.0, kRateMessages = 20.0;
constexpr double kTimerJitter_s = 0.02;

/// Passes each sample and the newest one that is at least `window_s` before it to `take`.
template <typename Point, typename Take>
void over_windows(const std::vector<Point>& points, double window_s, const Take& take) {
  std::size_t first = 0;
  for (std::size_t last = 1; last < points.size(); ++last) {
    const double latest = points[last].time_s - window_s + kTimerJitter_s;
    while (first + 1 < last && points[first + 1].time_s <= latest) ++first;
    if (points[first].time_s <= latest) take(points[first], points[last]);
  }
}

}  // namespace

void LoadTrack::add(double time_s, double cpu_s, double rss_mb, const Counts& published) {
  Point point{time_s, cpu_s, rss_mb, {}};
  for (const auto& [stream, count] : published) {
    const std::size_t number = numbers_.try_emplace(stream, numbers_.size()).first->second;
    if (point.published.size() <= number) point.published.resize(number + 1, 0);
    point.published[number] += count;
  }
  log_.add(std::move(point));
}

std::vector<Sample> LoadTrack::cpu_percents() const {
  std::vector<Sample> loads;
  over_windows(log_.samples(), kCpuWindow_s, [&](const Point& from, const Point& to) {
    loads.push_back({to.time_s, 100.0 * (to.cpu_s - from.cpu_s) / (to.time_s - from.time_s)});
  });
  return loads;
}

std::vector<Sample> LoadTrack::rss_mbs() const {
  std::vector<Sample> all;
  for (const Point& point : log_.samples()) all.push_back({point.time_s, point.rss_mb});
  return all;
}

std::vector<Sample> LoadTrack::rates_hz(const std::string& stream) const {
  const auto found = numbers_.find(stream);
  if (found == numbers_.end()) return {};
  const std::size_t number = found->second;
  auto points = log_.samples();
  // Before its first message it is not late.
  std::erase_if(points, [&](const Point& point) { return point.count(number) == 0; });
  if (points.size() < 2) return {};
  const double seconds = points.back().time_s - points.front().time_s;
  const auto growth = [&](const Point& from, const Point& to) {
    return static_cast<double>(to.count(number)) - static_cast<double>(from.count(number));
  };
  const double messages = growth(points.front(), points.back());
  if (!(messages > 0.0) || !(seconds > 0.0)) return {};
  const double window_s = std::max(kRateWindow_s, kRateMessages * seconds / messages);
  std::vector<Sample> rates;
  over_windows(points, window_s, [&](const Point& from, const Point& to) {
    rates.push_back({to.time_s, std::max(0.0, growth(from, to)) / (to.time_s - from.time_s)});
  });
  return rates;
}

double lowest_of(const std::vector<Sample>& samples) {
  const auto lowest = std::min_element(samples.begin(), samples.end(),
                                       [](const Sample& a, const Sample& b) { return a.value < b.value; });
  return lowest == samples.end() ? run_page::kUnknown : lowest->value;
}

}  // namespace nacelle::drive
