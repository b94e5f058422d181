// SPDX-License-Identifier: Apache-2.0
// filter [messages=1000] [late_ms=0] [smooths=1] [burst=0] [gyro_hz=100] [runs=5]
// The EKF's model on a drive of `messages` steps of 20 ms in two dimensions: wheels of 50 Hz, a gyro, poses of 10 Hz that come late_ms late, or
// all at once every two seconds (burst). Prints what the steps take, the longest in the shortest of all runs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

#include "ekf/model/covariance_parameter.hpp"
#include "ekf/model/filter.hpp"
#include "nacelle/base/time.hpp"
#include "support/arguments.hpp"
#include "support/usage.hpp"

namespace nacelle::bench {
namespace {

using namespace ekf;

constexpr WallTime kStart{1000s};
constexpr Duration kStep = 20ms;
constexpr int kWarmUp = 250;  // steps
constexpr int kPosesEvery = 5, kBurstEvery = 100;

struct Setup {
  int steps{};
  Duration late{};
  bool smooths{}, burst{};
  Duration gyro_period{};
};

struct Drive {
  std::vector<double> step_us;
  ReplayStats replays;
  std::uint64_t mallocs{}, fused{};
};

void offer(Filter& filter, std::uint16_t part, WallTime stamp, WallTime now, StateMask mask, double value) {
  filter.offer(part, stamp, now, [&](Reading& r) -> Prepared {
    r.rows = 0;
    r.gate = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kStates; ++i) {
      if (has(mask, i)) r.add(static_cast<StateIndex>(i), value, 1e-3);
    }
    for (const StateIndex flat : {kZ, kRoll, kPitch, kVz, kVroll, kVpitch, kAz}) r.add(flat, 0.0, 1e-6);
    return {};
  });
}

Drive drive(const Setup& setup, const Clock& clock) {
  FilterOptions options;
  options.process_noise = ProcessNoise{default_process_noise()};
  options.initial.covariance = default_initial_covariance();
  options.period = options.sensor_timeout = kStep;
  options.parts = 3;
  if (setup.smooths) options.history = 3s;
  Filter filter{options};
  Drive result;
  result.step_us.reserve(static_cast<std::size_t>(setup.steps));
  Usage before;
  for (int i = 0; i < setup.steps; ++i) {
    if (i == kWarmUp) before = Usage::now();
    const WallTime now = kStart + kStep * i;
    const double s = to_seconds(kStep) * i;
    for (Duration t = kStep - setup.gyro_period; t >= 0ns; t -= setup.gyro_period)
      offer(filter, 1, now - t, now, mask_of(kVyaw), 0.5 * std::sin(0.9 * s));
    offer(filter, 0, now, now, mask_of(kVx) | mask_of(kVy), 0.4);
    const auto pose = [&](WallTime stamp) {
      if (stamp >= kStart) offer(filter, 2, stamp, now, mask_of(kX) | mask_of(kY) | mask_of(kYaw), 0.1);
    };
    if (setup.burst) {
      for (int ago = kBurstEvery; i % kBurstEvery == 0 && ago >= 0; ago -= kPosesEvery) pose(now - kStep * ago);
    } else if (i % kPosesEvery == 0) {
      pose(now - setup.late);
    }
    const MonotonicTime begin = clock.now();
    filter.step(now, MonotonicTime{1s + kStep * i});
    result.step_us.push_back(to_seconds(clock.now() - begin) * 1e6);
  }
  result.mallocs = (Usage::now() - before).mallocs;
  result.replays = filter.replays();
  for (std::size_t part = 0; part < 3; ++part) result.fused += filter.stats(part).fused;
  return result;
}

}  // namespace
}  // namespace nacelle::bench

int main(int count, char** words) {
  using namespace nacelle;
  using namespace nacelle::bench;
  const Arguments arguments(count, words);
  const Setup setup{.steps = static_cast<int>(arguments.number("messages", 1000)),
                    .late = 1ms * static_cast<std::int64_t>(arguments.number("late_ms", 0)),
                    .smooths = arguments.number("smooths", 1) != 0,
                    .burst = arguments.number("burst", 0) != 0,
                    .gyro_period = Duration{1s} / static_cast<std::int64_t>(arguments.number("gyro_hz", 100))};
  const SystemClock clock;
  Drive shortest = drive(setup, clock);
  for (std::uint64_t run = 1; run < arguments.number("runs", 5); ++run) {
    const Drive again = drive(setup, clock);
    for (std::size_t i = 0; i < again.step_us.size(); ++i)
      shortest.step_us[i] = std::min(shortest.step_us[i], again.step_us[i]);
  }
  double sum = 0.0;
  double longest = 0.0;
  for (std::size_t i = std::min<std::size_t>(kWarmUp, shortest.step_us.size()); i < shortest.step_us.size(); ++i) {
    sum += shortest.step_us[i];
    longest = std::max(longest, shortest.step_us[i]);
  }
  print_figures({{"longest_us", longest},
                 {"mean_us", sum / std::max(1, setup.steps - kWarmUp)},
                 {"fused", static_cast<double>(shortest.fused)},
                 {"passes", static_cast<double>(shortest.replays.passes)},
                 {"replayed", static_cast<double>(shortest.replays.measurements)},
                 {"continued", static_cast<double>(shortest.replays.continued)},
                 {"mallocs", static_cast<double>(shortest.mallocs)}});
  return 0;
}
