// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nacelle/base/time.hpp"

namespace nacelle::replay {

/// The clock of a replay: it stands still until it is told the next time of the recording. Monotonic time is an hour at the recording's first
/// message, so that "a while ago" exists, whatever the machine and the process.
/// Threads: one at a time.
class ToldClock final : public Clock {
 public:
  explicit ToldClock(WallTime begin) : begin_(begin), wall_(begin) {}

  [[nodiscard]] MonotonicTime now() const override { return monotonic_of(wall_); }
  [[nodiscard]] WallTime wall_now() const override { return wall_; }
  [[nodiscard]] MonotonicTime monotonic_of(WallTime time) const { return {1h + (time - begin_)}; }
  /// Time does not go back: an earlier one changes nothing.
  void advance_to(MonotonicTime time) {
    if (time > now()) wall_ = begin_ + (time.since_origin - 1h);
  }

 private:
  const WallTime begin_;
  WallTime wall_;
};

}  // namespace nacelle::replay
