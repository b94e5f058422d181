// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "nacelle/base/time.hpp"

namespace nacelle::diff_drive {

/// Makes a speed of an encoder's counts.
///
/// With the times of edges, it is what was counted by the time between the newest edge and the newest one that was known before: exact however few
/// they are. While none comes, the speed is at most one count in the time since the last. Without such times it is what was counted since the last
/// call by the time since then, so a slow wheel's speed is a row of steps.
/// Units: counts per second. Threads: one. Allocates: nothing.
class CountRate {
 public:
  /// Takes the count at `now`, and when its newest edge came, if that is known. Returns the rate.
  double update(std::int64_t count, std::optional<MonotonicTime> edge_at, MonotonicTime now);
  void reset() { has_last_ = false; }

  /// Without an edge for so long a wheel stands.
  static constexpr Duration kStandsAfter = 500ms;

 private:
  bool has_last_ = false;
  std::int64_t last_count_ = 0;
  MonotonicTime last_edge_at_{}, last_at_{};
  double rate_ = 0.0;
};

}  // namespace nacelle::diff_drive
