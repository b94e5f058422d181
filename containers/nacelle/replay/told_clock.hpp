// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>

#include "nacelle/base/time.hpp"

namespace nacelle::replay {

/// The clock of a replay: it stands still until it is told the next time of the recording. Monotonic time is an hour at the recording's first
/// message, so that "a while ago" exists, whatever the machine and the process.
/// Threads: one advances it.
class ToldClock final : public Clock {
 public:
  explicit ToldClock(WallTime begin) : begin_(begin) {}

  [[nodiscard]] MonotonicTime now() const override { return {1h + passed_.load(std::memory_order_relaxed)}; }
  [[nodiscard]] WallTime wall_now() const override { return begin_ + passed_.load(std::memory_order_relaxed); }
  [[nodiscard]] MonotonicTime monotonic_of(WallTime time) const { return {1h + (time - begin_)}; }
  /// Time does not go back: an earlier one changes nothing.
  void advance_to(MonotonicTime time) {
    if (time > now()) passed_.store(time.since_origin - 1h, std::memory_order_relaxed);
  }

 private:
  const WallTime begin_;
  std::atomic<Duration> passed_{Duration::zero()};
};

}  // namespace nacelle::replay
