// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "nacelle/base/time.hpp"

namespace nacelle::test {

/// Simulated time: it stands still until a test advances it. Starts at one second, so that "a while ago" exists; the
/// wall clock starts in November 2023. Threads: any.
class ManualClock final : public Clock {
 public:
  [[nodiscard]] MonotonicTime now() const override { return {Duration{monotonic_ns_.load()}}; }
  [[nodiscard]] WallTime wall_now() const override { return {Duration{wall_ns_.load()}}; }
  void advance(Duration by) {
    monotonic_ns_ += by.count();
    wall_ns_ += by.count();
  }
  /// NTP answered: only the wall clock moves.
  void step_wall(Duration by) { wall_ns_ += by.count(); }

 private:
  std::atomic<std::int64_t> monotonic_ns_{1'000'000'000};
  std::atomic<std::int64_t> wall_ns_{1'700'000'000'000'000'000};
};

}  // namespace nacelle::test
